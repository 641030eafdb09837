// Only here: a session of the real programs, recorded and played again against fresh ones, comes out the same; and a
// message that was changed by a hundredth of a radian does not.
#include <algorithm>

#include "tests/replay/recordings.hpp"
#include "tests/system/system_rig.hpp"

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
    if (e.has_joint_goal() && ++goals == 2) e.mutable_joint_goal()->set_q_real_rad(2, e.joint_goal().q_real_rad(2) + 0.01);
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

}  // namespace
}  // namespace armsight::demo
