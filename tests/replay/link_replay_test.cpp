// Only here: a session of the real programs, recorded and played again against fresh ones, comes out the same; and a
// message that was changed by a hundredth of a radian does not.
#include <algorithm>

#include "tests/replay/recordings.hpp"
#include "tests/system/system_rig.hpp"
#include "tools/replay/link_file.hpp"

namespace armsight::demo {
namespace {

namespace fs = std::filesystem;

class LinkReplay : public SystemTest {
 protected:
  LinkReplay() {
    options_ = quiet_robot();
    options_.noise = "nominal";  // the noise, too, must come again
    fs::create_directories(files_);
  }
  ~LinkReplay() override {
    if (!HasFailure()) fs::remove_all(files_);
  }

  /// What every client of this run is told: --arm ADDR:PORT --clock sim:PATH.
  std::vector<std::string> whereabouts() {
    const std::vector<std::string> host = arm().host_command({});
    std::vector<std::string> words;
    for (const char* flag : {"--arm", "--clock"}) {
      const auto at = std::ranges::find(host, flag);
      words.insert(words.end(), {*at, *std::next(at)});
    }
    return words;
  }

  fs::path record_moves() {
    start(options_);
    EXPECT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
    EXPECT_EQ(arm().host({"move", "--joints=0.60,0.10,-0.30,1.20,-0.60"}), 0);
    return keep_recording();
  }

  /// Ends the programs in order; the controller's recording survives them.
  fs::path keep_recording() {
    conductor().end("arm_controller");
    const fs::path kept = files_ / "recorded.mcap";
    fs::copy_file(folder_ / "controller/ticks.mcap", kept, fs::copy_options::overwrite_existing);
    arm_.reset();
    return kept;
  }

  /// link_record between the next host and the controller, and where it listens. Simulated time stands still meanwhile.
  std::string start_recorder(const fs::path& out) {
    const std::vector<std::string> command{(options_.programs / "link_record").string(), "--arm", whereabouts()[1],
                                           "--out", out.string()};
    recorder_ = std::make_unique<ChildProcess>("link_record", command);
    while (!recorder_->line_after("link_record: listening on ") && !recorder_->exit_code())
      recorder_->drain([](const std::string&) {});
    return recorder_->line_after("link_record: listening on ").value_or("");
  }

  std::vector<std::string> host_through(const std::string& relay, const std::vector<std::string>& verb) {
    std::vector<std::string> command = arm().host_command(verb);
    *std::next(std::ranges::find(command, "--arm")) = relay;
    return command;
  }

  int end_of_recorder() {
    while (!recorder_->exit_code()) recorder_->drain([](const std::string&) {});
    return *recorder_->exit_code();
  }

  int replay(const fs::path& recording) {
    if (!arm_) start(options_);
    std::vector<std::string> command{(options_.programs / "link_replay").string(), recording.string()};
    for (const std::string& word : whereabouts()) command.push_back(word);
    const int code = conductor().run("link_replay", command, &lines_);
    arm_.reset();
    return code;
  }

  std::string said() const {
    std::string all;
    for (const std::string& line : lines_) all += line + "\n";
    return all;
  }

  DemoOptions options_;
  fs::path files_ = folder_.string() + "-recordings";
  std::vector<std::string> lines_;
  std::unique_ptr<ChildProcess> recorder_;
};

TEST_F(LinkReplay, FreshProgramsAnswerAsRecorded) {
  const fs::path recording = record_moves();
  EXPECT_EQ(replay(recording), 0) << said();
  EXPECT_NE(said().find("connection 2: same"), std::string::npos) << said();
}

TEST_F(LinkReplay, NamesTheFirstDifferenceOfAChangedGoal) {
  const fs::path recording = record_moves(), changed = files_ / "changed.mcap";
  int goals = 0;
  replay::copy_recording(recording, changed, [&](wire::LinkRecord& record) {
    wire::Envelope& e = *record.mutable_envelope();
    if (e.has_joint_goal() && ++goals == 2)
      e.mutable_joint_goal()->set_q_real_rad(2, e.joint_goal().q_real_rad(2) + 0.01);
  });
  ASSERT_EQ(goals, 2);
  EXPECT_EQ(replay(changed), 1) << said();
  EXPECT_NE(said().find("connection 1: same"), std::string::npos) << said();
  EXPECT_NE(said().find("different, first: connection 2: differs at "), std::string::npos) << said();
  EXPECT_NE(said().find(", /link, "), std::string::npos) << said();
}

TEST_F(LinkReplay, RefusesASimulatorOfAnotherSeed) {
  const fs::path recording = record_moves();
  options_.seed = 2;
  EXPECT_EQ(replay(recording), 2) << said();
  EXPECT_NE(said().find("arm_sim needs the seed"), std::string::npos) << said();
}

TEST_F(LinkReplay, RecorderBetweenHostAndControllerChangesNothing) {
  start(options_);
  const fs::path recording = files_ / "link.mcap";
  const std::string relay = start_recorder(recording);
  EXPECT_EQ(conductor().run("host", host_through(relay, {"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"})), 0);
  EXPECT_EQ(end_of_recorder(), 0);
  arm_.reset();
  EXPECT_EQ(replay(recording), 0) << said();
}

TEST_F(LinkReplay, RecorderThatIsEndedLeavesAWholeFile) {
  start(options_);
  const fs::path recording = files_ / "link.mcap";
  const std::string relay = start_recorder(recording);
  conductor().start("host", host_through(relay, {"move", "--joints=1.4,0.7,-1.3,2.2,1.2", "--speed", "0.3"}));
  conductor().run_cycles(250);
  recorder_->send_signal(SIGTERM);
  EXPECT_EQ(end_of_recorder(), 0);
  conductor().kill("host");
  const replay::LinkFile file = replay::load_link_file(recording);
  ASSERT_EQ(file.connections.size(), 1u);
  EXPECT_GT(file.connections[0].to_controller.size(), 10u);
  EXPECT_GT(file.connections[0].from_controller.size(), 10u);
}

TEST_F(LinkReplay, HostsAtTheSameTimeComeAgainAtTheSameTime) {
  start(options_);
  ASSERT_EQ(arm().host({"move", "--joints=0.44,0.14,-0.26,1.37,-0.80"}), 0);
  conductor().start("host", arm().host_command({"move", "--joints=0.84,0.14,-0.26,1.37,-0.80", "--speed", "0.3"}));
  conductor().run_cycles(100);
  conductor().start("host", arm().host_command({"stop"}));  // taken from anybody
  conductor().run_cycles(500);
  const fs::path recording = keep_recording();
  EXPECT_EQ(replay(recording), 0) << said();
  EXPECT_NE(said().find("connection 3: same"), std::string::npos) << said();
}

TEST_F(LinkReplay, LooksAreFusedAsRecorded) {
  start(options_);
  ASSERT_EQ(arm().host({"adapt", "--looks", "2"}), 0);
  const fs::path recording = keep_recording();
  const replay::LinkFile file = replay::load_link_file(recording);
  const auto is_report = [](const wire::LinkRecord& record) { return record.envelope().has_filter_report(); };
  ASSERT_GE(std::ranges::count_if(file.messages, is_report), 2);
  EXPECT_EQ(replay(recording), 0) << said();
}

}  // namespace
}  // namespace armsight::demo
