// Only here: a node that reboots under way makes the real controller keep its last cycles; the host fetches them over
// the link, and the same executable goes through them again, bit by bit. One bit of one frame changed is reported.
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>

#include "arm_controller/emulated_bus_wire.hpp"
#include "protocol/descriptor.hpp"
#include "protocol/recording.pb.h"
#include "tests/replay/edited_recording.hpp"
#include "tests/system/real_pace_rig.hpp"

namespace armsight::demo {
namespace {

namespace fs = std::filesystem;

class BlackBoxOfTheProgram : public RealPace {
 protected:
  /// A frame of nobody's onto the emulated bus: at real pace a stranger may send, in lockstep only listen.
  void inject(const CanFrame& frame) {
    const std::string line = arm().bus_line();
    const std::size_t begin = line.find(':') + 1;
    const std::string path = line.substr(begin, line.find(' ') - begin);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    stranger_ = Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
    ASSERT_EQ(::connect(stranger_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0) << path;
    const arm::BusPacketBytes join = arm::encode_bus_join(0), packet = arm::encode_bus_packet({0, frame, 0});
    ASSERT_EQ(::send(stranger_.get(), join.data(), join.size(), 0), 24);
    ASSERT_EQ(::send(stranger_.get(), packet.data(), packet.size(), 0), 24);
  }

  int replay(const fs::path& file) {
    lines_.clear();
    return conductor().run("link_replay", {(quiet_robot().programs / "link_replay").string(), file.string()}, &lines_);
  }

  /// The bit in the middle of the file's received position samples of node 3.
  fs::path with_one_bit_flipped(const fs::path& file) {
    const fs::path changed = folder_ / "changed.mcap";
    int seen = 0;
    test::edit_recording(file, changed, [&](RecordedMessage& message) {
      wire::CanRecord frame;
      const bool is_sample = message.topic == "/can" && frame.ParseFromString(message.data) && frame.id() == 0x183;
      if (!is_sample || ++seen != 100) return;
      (*frame.mutable_data())[3] = static_cast<char>(frame.data()[3] ^ 1);
      message.data = frame.SerializeAsString();
    });
    return changed;
  }

  Descriptor stranger_;
  std::vector<std::string> lines_;
};

TEST_F(BlackBoxOfTheProgram, IsFetchedAndGoneThroughAgain) {
  go_to_start();
  inject(encode(Nmt{NmtCommand::kResetNode, 3}));
  conductor().run_cycles(100);
  const fs::path fetched = folder_ / "fetched.mcap";
  ASSERT_EQ(arm().host({"blackbox", "--out", fetched.string()}), 0);
  EXPECT_EQ(replay(fetched), 0) << (lines_.empty() ? "" : lines_.back());
  EXPECT_EQ(replay(with_one_bit_flipped(fetched)), 1);
  ASSERT_FALSE(lines_.empty());
  EXPECT_TRUE(lines_.back().starts_with("arm_controller: different, first: cycle ")) << lines_.back();
}

}  // namespace
}  // namespace armsight::demo
