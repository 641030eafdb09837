// Only here: what a person asks the host for is what the drives get, judged by the bus and the simulator's truth.
#include <csignal>

#include "tests/system/system_rig.hpp"

namespace armsight::demo {
namespace {

class OperatorVerbs : public SystemTest {
 protected:
  bool has_line(const std::string& start) {
    return std::ranges::any_of(arm().host_lines(), [&](const std::string& l) { return l.starts_with(start); });
  }
  std::string all_lines() {
    std::string all;
    for (const std::string& line : arm().host_lines()) all += line + "\n";
    return all;
  }
  std::string mode() {
    EXPECT_EQ(arm().host({"status"}), 0);
    const auto line = std::ranges::find_if(arm().host_lines(), [](const auto& l) { return l.starts_with("mode:"); });
    return line == arm().host_lines().end() ? "" : *line;
  }
  /// Steps until a program has ended by itself; its exit code.
  int end_of(const std::string& name) {
    for (int i = 0; i < 200 && !conductor().find(name)->exit_code(); ++i) conductor().run_cycles(25);
    return conductor().end(name);
  }
  /// A joint's way of 1.2 rad at 0.2 rad/s, and three seconds of it.
  void move_slowly() {
    ASSERT_EQ(arm().host({"move", "--joints=0.2,-0.2,-0.2,1.5,0.0"}), 0) << all_lines();
    conductor().start("host", arm().host_command({"move", "--joints=1.4,-0.2,-0.2,1.5,0.0", "--speed", "0.1"}));
    conductor().run_cycles(750);
    ASSERT_FALSE(conductor().find("host")->exit_code()) << "it should be under way";
  }
  JointVector true_joints(const Truth& truth) { return truth.rows.back().q_true; }
};

TEST_F(OperatorVerbs, PowerGoesOnByEnableAndMoveAndOffByDisable) {
  start(quiet_robot());
  EXPECT_EQ(arm().host({"enable"}), 0) << all_lines();
  EXPECT_NE(mode().find("hold"), std::string::npos);
  EXPECT_EQ(arm().host({"disable"}), 0) << all_lines();
  EXPECT_NE(mode().find("ready"), std::string::npos);
  EXPECT_EQ(arm().host({"move", "ready"}), 0) << all_lines();
  EXPECT_EQ(arm().host({"park", "--disable", "--speed", "0.5"}), 0) << all_lines();
  EXPECT_NE(mode().find("ready"), std::string::npos) << "park --disable leaves the power off";
  const Truth truth = arm().finish();
  const JointVector park = load_robot(quiet_robot().robot_file).postures.at("park");
  EXPECT_LT((true_joints(truth) - truth.after.beta - park).cwiseAbs().maxCoeff(), 0.01);
}

TEST_F(OperatorVerbs, ADryRunTellsTheMotionAndSendsTheDrivesNothing) {
  start(quiet_robot());
  conductor().run_cycles(1200);
  const std::size_t before = read_bus_log(folder_).size();
  ASSERT_GT(before, 100u);
  EXPECT_EQ(arm().host({"move", "--dry-run", "ready"}), 0);
  EXPECT_TRUE(has_line("  takes ")) << all_lines();
  EXPECT_EQ(arm().host({"park", "--dry-run"}), 0) << all_lines();
  EXPECT_EQ(arm().host({"hand", "close", "--dry-run"}), 0) << all_lines();
  EXPECT_EQ(arm().host({"adapt", "--dry-run", "--looks", "2"}), 0) << all_lines();
  EXPECT_TRUE(has_line("adapt: look 2")) << all_lines();
  EXPECT_EQ(arm().host({"move", "--dry-run", "--joints=0,0.9,0,1,0"}), 1) << "beyond a limit: " << all_lines();
  EXPECT_NE(mode().find("ready"), std::string::npos) << "no power was asked for";
  const std::vector<CandumpLine> frames = read_bus_log(folder_);
  for (std::size_t i = before; i < frames.size(); ++i) {
    const bool is_rpdo1 = (frames[i].frame.id & 0x780) == 0x200;
    if (!is_rpdo1) continue;
    ASSERT_NE(frames[i].frame.data[0] & 0x0F, 0x0F) << "a drive was told to enable operation";
  }
}

TEST_F(OperatorVerbs, AMoveIntoTheFloorIsRefusedByNameBeforeAnythingMoves) {
  DemoOptions options = quiet_robot();
  const std::filesystem::path raised = robot_file("high_floor");
  write_changed_robot(options.robot_file, raised, {{"offset_m: -0.49", "offset_m: -0.30"}});
  options.robot_file = raised;
  start(options);
  ASSERT_EQ(arm().host({"move", "ready"}), 0) << all_lines();
  EXPECT_EQ(arm().host({"move", "--dry-run", "--joints=0.2,-0.2,0,0.1,0"}), 1);
  EXPECT_NE(all_lines().find("would be refused: hand comes within"), std::string::npos) << all_lines();
  EXPECT_NE(all_lines().find("of floor (margin 5.0 mm)"), std::string::npos) << all_lines();
  EXPECT_EQ(arm().host({"move", "--joints=0.2,-0.2,0,0.1,0"}), 1);
  EXPECT_NE(all_lines().find("of floor (margin 5.0 mm)"), std::string::npos) << all_lines();
  const Truth truth = arm().finish();
  const JointVector ready = load_robot(raised).postures.at("ready");
  EXPECT_LT((true_joints(truth) - truth.after.beta - ready).cwiseAbs().maxCoeff(), 0.02) << "nothing moved";
}

TEST_F(OperatorVerbs, CtrlCUnderWayStopsAndHolds) {
  start(quiet_robot());
  move_slowly();
  conductor().find("host")->send_signal(SIGINT);
  EXPECT_EQ(end_of("host"), 1);
  conductor().run_cycles(100);
  const std::string now = mode();
  EXPECT_NE(now.find("hold"), std::string::npos) << now;
  EXPECT_NE(now.find("still"), std::string::npos) << now;
  const Truth truth = arm().finish();
  EXPECT_LT(true_joints(truth)[0], 1.0) << "it stopped before its goal";
  EXPECT_LT(speed_rad_s(truth, truth.rows.size() - 2), 0.01);
}

// The fault: a model that cannot be saved, because a folder stands where its file should.
TEST_F(OperatorVerbs, AFaultIsClearedByTheWordAloneAndThePowerStaysOff) {
  start(quiet_robot());
  EXPECT_EQ(arm().host({"clear"}), 0);
  EXPECT_TRUE(has_line("clear: no fault")) << all_lines();
  std::filesystem::create_directories(folder_ / "controller/model.yaml/in the way");
  EXPECT_NE(arm().host({"adapt", "--looks", "1"}), 0) << all_lines();
  ASSERT_NE(mode().find("fault"), std::string::npos) << all_lines();
  EXPECT_EQ(arm().host({"enable"}), 1);
  EXPECT_EQ(arm().host({"disable"}), 1);
  EXPECT_EQ(arm().host({"move", "ready"}), 1);
  std::filesystem::remove_all(folder_ / "controller/model.yaml");
  EXPECT_EQ(arm().host({"clear"}), 0) << all_lines();
  EXPECT_NE(mode().find("ready"), std::string::npos);
  EXPECT_EQ(arm().host({"enable"}), 0) << all_lines();
}

TEST_F(OperatorVerbs, AMoveWhoseLinkIsLostEndsAndSaysSo) {
  start(quiet_robot());
  move_slowly();
  conductor().kill("arm_controller");
  EXPECT_EQ(end_of("host"), 3);
  const std::string said = conductor().find("host")->last_lines();
  EXPECT_NE(said.find("moves again only by a new command"), std::string::npos) << said;
}

TEST_F(OperatorVerbs, AWatcherConnectsAgain) {
  start(quiet_robot());
  conductor().start("host", arm().host_command({"status", "--watch", "--for", "15"}));
  conductor().run_cycles(500);
  conductor().kill("arm_controller");
  conductor().run_cycles(500);
  arm().start_controller();
  EXPECT_EQ(end_of("host"), 0) << conductor().find("host")->last_lines();
  const auto seen = conductor().find("host")->lines();
  const auto again = std::ranges::find(seen, "watch: connected again");
  ASSERT_NE(again, seen.end());
  EXPECT_NE(std::next(again), seen.end()) << "it tells the state again";
}

}  // namespace
}  // namespace armsight::demo
