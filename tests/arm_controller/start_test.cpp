// Starting: flags, a missing interface, a damaged state folder. Nothing moves, nothing is overwritten.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <fstream>

#include "arm_controller/program.hpp"
#include "arm_controller/socket_can.hpp"
#include "arm_controller/state_folder.hpp"
#include "protocol/transport/framed_stream.hpp"
#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

Flags parse(std::vector<const char*> words) {
  words.insert(words.begin(), "arm_controller");
  return parse_flags(static_cast<int>(words.size()), words.data());
}

std::string complaint(std::vector<const char*> words) {
  try {
    parse(std::move(words));
  } catch (const FlagError& e) {
    return e.what();
  }
  return "";
}

TEST(Flags, ReadTheContract) {
  const Flags f = parse({"--config", "r.yaml", "--listen=127.0.0.1:0", "--state", "s", "--bus", "emulated:/b",
                         "--clock", "sim:/c", "--rate", "500"});
  EXPECT_EQ(f.config, "r.yaml");
  EXPECT_EQ(f.emulated_bus, std::vector<std::string>{"/b"});
  EXPECT_EQ(f.sim_clock, "/c");
  EXPECT_EQ(f.rate_hz, 500.0);
}

TEST(Flags, TakeABusMoreThanOnce) {
  const Flags f = parse({"--config", "r.yaml", "--listen=127.0.0.1:0", "--state", "s", "--can", "can0", "--can=can1"});
  EXPECT_EQ(f.can, (std::vector<std::string>{"can0", "can1"}));
}

TEST(Flags, RefuseWhatIsUnknownMissingOrOpenToTheNetwork) {
  EXPECT_NE(complaint({"--confg", "x"}).find("--confg: unknown"), std::string::npos);
  EXPECT_NE(complaint({"--config", "x"}).find("--listen is missing"), std::string::npos);
  EXPECT_NE(complaint({"--config", "x", "--listen", "0.0.0.0:1", "--state", "s", "--can", "can0"}).find("loopback"),
            std::string::npos);
  EXPECT_NE(complaint({"--config", "x", "--listen", "127.0.0.1:0", "--state", "s"}).find("exactly one"),
            std::string::npos);
  EXPECT_NE(complaint({"--rate", "fast"}).find("must be a number"), std::string::npos);
}

std::string complaint_at_rate(double rate_hz) {
  Flags flags =
      parse({"--config", kRobotFile, "--listen", "127.0.0.1:0", "--state", "/proc/none", "--can", "can_none"});
  flags.rate_hz = rate_hz;
  try {
    Program program(flags);
  } catch (const FlagError& e) {
    return e.what();
  } catch (const ConfigError&) {  // the state folder comes next: the rate was taken
  }
  return "";
}

TEST(Rate, KeepsTheRulesOfTheConfiguration) {
  EXPECT_NE(complaint_at_rate(300).find("--rate 300"), std::string::npos);
  EXPECT_NE(complaint_at_rate(300).find("whole number, 1 to 255, of 1 ms or of 0.1 ms"), std::string::npos);
  EXPECT_NE(complaint_at_rate(50).find("rpdo_deadline_s must be at least two periods"), std::string::npos);
  for (const double good : {125.0, 250.0, 400.0, 500.0}) EXPECT_EQ(complaint_at_rate(good), "");
}

TEST(Rate, RefusesWhatTheBusDoesNotCarryAndNamesWhatItDoes) {
  const std::string why = complaint_at_rate(1000);
  EXPECT_NE(why.find("--rate 1000"), std::string::npos) << why;
  EXPECT_NE(why.find("loaded to 169.6 %, above 90 %"), std::string::npos) << why;
  EXPECT_NE(why.find("the highest rate that fits is 526.3 Hz"), std::string::npos) << why;
  EXPECT_NE(why.find("needs 2 buses"), std::string::npos) << why;
}

TEST(Start, WantsAsManyBusesAsTheRobotHas) {
  const Flags flags = parse({"--config", kRobotFile, "--listen", "127.0.0.1:0", "--state", "/proc/none",
                             "--can", "can0", "--can", "can1"});
  try {
    Program program(flags);
    FAIL() << "took a bus that no drive is on";
  } catch (const FlagError& e) {
    EXPECT_NE(std::string(e.what()).find("--can is given 2 times"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("are on 1 bus"), std::string::npos) << e.what();
  }
}

TEST(SocketCan, ReportsAMissingInterfaceAndNeverFallsBack) {
  const auto clock = net::make_monotonic_clock(std::chrono::milliseconds(4));
  try {
    open_socket_can("can_none", *clock);
    FAIL() << "opened an interface that does not exist";
  } catch (const BusError& e) {
    EXPECT_NE(std::string(e.what()).find("'can_none'"), std::string::npos) << e.what();
  }
}

/// A folder with a recording, and a hub that takes connections and says nothing.
class StartPlace {
 public:
  StartPlace() {
    std::string pattern = (std::filesystem::temp_directory_path() / "arm_start_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    std::ofstream(folder / "ticks.mcap") << "the last one";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    (folder / "bus").string().copy(address.sun_path, sizeof address.sun_path - 1);
    hub_ = Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    EXPECT_EQ(::bind(hub_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(hub_.get(), 4), 0);
  }
  ~StartPlace() { std::filesystem::remove_all(folder); }

  /// What a start complains about; empty: it began.
  std::string start(const std::string& listen) const {
    const std::string bus = "emulated:" + (folder / "bus").string();
    try {
      Program program(parse({"--config", kRobotFile, "--listen", listen.c_str(), "--state", folder.c_str(), "--bus",
                             bus.c_str()}));
    } catch (const std::exception& e) {
      return e.what();
    }
    return "";
  }
  bool recording_is_in_place() const { return std::filesystem::file_size(folder / "ticks.mcap") == 12; }

  std::filesystem::path folder;

 private:
  Descriptor hub_;
};

TEST(Start, AtATakenAddressLeavesTheLastRecordingInPlace) {
  const StartPlace place;
  const auto other = net::listen_tcp("127.0.0.1:0");
  EXPECT_NE(place.start("127.0.0.1:" + std::to_string(other->port())), "");
  EXPECT_TRUE(place.recording_is_in_place());
  EXPECT_EQ(place.start("127.0.0.1:0"), "");
  EXPECT_TRUE(std::filesystem::exists(place.folder / "ticks-previous.mcap"));
}

TEST(Start, OfASecondControllerInAStateFolderIsRefused) {
  const StartPlace place;
  {
    const Descriptor first = hold_state_folder(place.folder);
    EXPECT_NE(place.start("127.0.0.1:0").find("another arm_controller works there"), std::string::npos);
    EXPECT_TRUE(place.recording_is_in_place());
  }
  EXPECT_EQ(place.start("127.0.0.1:0"), "");
}

TEST(StateFolder, RefusesADamagedModelAndLeavesItAsItIs) {
  std::string pattern = (std::filesystem::temp_directory_path() / "arm_state_XXXXXX").string();
  const std::filesystem::path folder = ::mkdtemp(pattern.data());
  std::ofstream(folder / "model.yaml") << "robot: [";
  EXPECT_THROW(load_model_in_force(folder, nominal_robot()), ConfigError);
  EXPECT_EQ(std::filesystem::file_size(folder / "model.yaml"), 8u);
  std::filesystem::remove_all(folder);
}

TEST(StateFolder, RefusesAModelBeyondTheControllersRulesAndLeavesItAsItIs) {
  const StartPlace place;
  const RobotConfig robot = nominal_robot();
  ModelEvent model{nominal_start(robot).model, StateMatrix::Identity(11, 11) * 1e-4, ModelSource::kCalibration, {}};
  const auto complaint_about = [&](const ModelEvent& bad) -> std::string {
    save_model_in_force(place.folder, robot, bad);
    const auto bytes = std::filesystem::file_size(place.folder / "model.yaml");
    const std::string complaint = place.start("127.0.0.1:0");
    EXPECT_EQ(std::filesystem::file_size(place.folder / "model.yaml"), bytes);
    return complaint;
  };
  EXPECT_EQ(complaint_about(model), "");
  ModelEvent bent = model, far = model, indefinite = model;
  bent.model.beta[1] = 0.36;
  far.model.T_C_B.p = {4.0, 0.0, 4.0};
  indefinite.P(0, 7) = indefinite.P(7, 0) = 2e-4;
  EXPECT_NE(complaint_about(bent).find("beta_rad"), std::string::npos);
  EXPECT_NE(complaint_about(far).find("T_C_B"), std::string::npos);
  EXPECT_NE(complaint_about(indefinite).find("covariance"), std::string::npos);
}

TEST(Start, KeepsARecordingThatItCannotMoveAside) {
  const StartPlace place;
  std::filesystem::create_directories(place.folder / "ticks-previous.mcap" / "in the way");
  EXPECT_NE(place.start("127.0.0.1:0").find("ticks-previous.mcap"), std::string::npos);
  EXPECT_TRUE(place.recording_is_in_place());
}

TEST(Flags, TakeAnAddressForWhatItResolvesTo) {
  const auto listen = [](const std::string& address) {
    return parse({"--config", "r", "--listen", address.c_str(), "--state", "s", "--can", "can0"}).listen;
  };
  EXPECT_EQ(listen("127.0.0.1:5"), "127.0.0.1:5");
  EXPECT_EQ(listen("localhost:0"), "127.0.0.1:0");
  const std::string not_a_name = "127." + std::string(64, 'x');  // too long for any resolver to ask around
  for (const std::string host : {"0.0.0.0", "::1", not_a_name.c_str()}) {
    const std::string address = host + ":0";
    EXPECT_NE(complaint({"--config", "r", "--listen", address.c_str(), "--state", "s", "--can", "can0"})
                  .find("--listen " + address),
              std::string::npos) << host;
  }
}

}  // namespace
}  // namespace armsight::arm::test
