// The filter's behaviour on a recorded adapt is frozen in golden/bench_look.csv. A refactoring leaves it untouched; a
// change of behaviour commits the new table (ekf_replay FILE --update) and says why.
// How the recording was made: tests/replay/README.md.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "tests/replay/recordings.hpp"
#include "tools/replay/filter_replay.hpp"
#include "tools/report/child_process.hpp"

namespace armsight::replay {
namespace {

namespace fs = std::filesystem;

const fs::path kBench = fs::path(ARMSIGHT_HOME) / "tests/replay/bench_look.mcap";
const fs::path kGolden = fs::path(ARMSIGHT_HOME) / "tests/replay/golden/bench_look.csv";

class EkfReplay : public testing::Test {
 protected:
  EkfReplay() { fs::create_directories(folder_); }
  ~EkfReplay() override { fs::remove_all(folder_); }

  int run(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> command{(fs::read_symlink("/proc/self/exe").parent_path() / program).string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    demo::ChildProcess child(program, command);
    while (!child.exit_code()) usleep(1000);
    child.drain([](const std::string&) {});
    said_ = child.last_lines();
    return *child.exit_code();
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("armsight-ekf-replay-" + std::to_string(getpid()));
  std::string said_;
};

TEST_F(EkfReplay, ReproducesTheGoldenTable) { EXPECT_EQ(run("ekf_replay", {kBench.string()}), 0) << said_; }

TEST_F(EkfReplay, DoesWhatTheControllerDidWithTheSameLooks) {
  const LinkFile file = load_link_file(kBench);
  const RobotConfig robot = parse_robot(file.info->configuration(), "bench_look.mcap/info");
  for (const FilterStep& step : replay_filter(file, robot)) {
    EXPECT_EQ(step.model.revision, step.recorded.model_revision());
    EXPECT_EQ(step.report.iterations, static_cast<int>(step.recorded.iterations()));
    EXPECT_NEAR(step.report.nis, step.recorded.nis(), 1e-9);
    EXPECT_NEAR(step.report.cost, step.recorded.cost(), 1e-9);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(step.hand_sigma[i], step.recorded.hand_sigma(i), 1e-12) << i;
  }
}

TEST_F(EkfReplay, NamesLookAndColumnOfADifference) {
  const fs::path changed = folder_ / "changed.mcap";
  int looks = 0;
  copy_recording(kBench, changed, [&](wire::LinkRecord& record) {
    if (!record.envelope().has_hand_pose() || ++looks != 3) return;
    wire::Pose& pose = *record.mutable_envelope()->mutable_hand_pose()->mutable_hand_in_camera();
    pose.set_x_m(pose.x_m() + 1e-6);
  });
  EXPECT_EQ(run("ekf_replay", {changed.string(), "--golden", kGolden.string()}), 1) << said_;
  EXPECT_NE(said_.find("different: look 3, nis: golden "), std::string::npos) << said_;
}

TEST_F(EkfReplay, UpdateWritesTheTable) {
  const fs::path table = folder_ / "golden.csv";
  EXPECT_EQ(run("ekf_replay", {kBench.string(), "--golden", table.string(), "--update"}), 0) << said_;
  EXPECT_EQ(first_csv_difference(bytes_of(kGolden), bytes_of(table)), "");
}

TEST_F(EkfReplay, DamagedRecordingsAreRefusedWithOneLine) {
  const std::string whole = bytes_of(kBench);
  std::string damaged = whole;
  damaged[damaged.size() / 2] ^= 0x10;
  const fs::path bad = folder_ / "damaged.mcap", cut = folder_ / "cut.mcap", foreign = folder_ / "foreign.mcap";
  write_bytes(bad, damaged);
  write_bytes(cut, whole.substr(0, whole.size() * 2 / 3));
  write_bytes(foreign, "this is no recording");
  for (const fs::path& file : {bad, cut, foreign, folder_ / "missing.mcap"}) {
    EXPECT_EQ(run("ekf_replay", {file.string()}), 2) << file;
    EXPECT_NE(said_.find("ekf_replay: " + file.string() + ": "), std::string::npos) << said_;
    EXPECT_EQ(run("link_replay", {file.string(), "--arm", "127.0.0.1:1", "--clock", "sim:nowhere"}), 2) << file;
    EXPECT_NE(said_.find("link_replay: " + file.string() + ": "), std::string::npos) << said_;
  }
}

TEST_F(EkfReplay, RecordingsNeverDriveARealArm) {
  EXPECT_EQ(run("link_replay", {kBench.string(), "--arm", "127.0.0.1:1"}), 2);
  EXPECT_NE(said_.find("never to a real one"), std::string::npos) << said_;
}

}  // namespace
}  // namespace armsight::replay
