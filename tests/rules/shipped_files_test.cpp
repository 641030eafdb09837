// Every configuration file in the repository loads, with the loader of the program it is for.
#include <gtest/gtest.h>

#include "host/grasp_table.hpp"
#include "protocol/config.hpp"
#include "tools/report/evaluation.hpp"
#include "tools/sim/scene.hpp"

namespace armsight {
namespace {

const std::filesystem::path kHome = ARMSIGHT_HOME;
const std::filesystem::path kNominal = kHome / "arm_controller/config/ego_right_arm.yaml";

TEST(ShippedFiles, RobotFilesLoad) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kHome / "arm_controller/config")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(load_robot(entry.path())) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 1);
}

TEST(ShippedFiles, GraspTableSceneAndExperimentLoad) {
  EXPECT_NO_THROW(host::GraspTable::load(kHome / "host/config/grasps.yaml").find("can"));
  EXPECT_EQ(sim::load_scene(kHome / "tools/sim/scene.yaml").object.name, "can");
  const demo::Experiment e = demo::load_experiment(kHome / "tools/experiments/chapter8.yaml", load_robot(kNominal));
  EXPECT_EQ(e.commanded_q_real.size(), 5u);
}

TEST(ShippedFiles, DemoRobotDiffersInSpeedsAlone) {
  const RobotConfig nominal = load_robot(kNominal);
  RobotConfig demo = load_robot(kHome / "tools/experiments/demo_robot.yaml");
  EXPECT_TRUE((demo.arm.limits.max_speed_rad_s.array() == 2.0).all());
  const JointLimits limits = nominal.arm.limits;
  demo.arm.limits.max_speed_rad_s = limits.max_speed_rad_s;
  demo.arm.limits.max_acceleration_rad_s2 = limits.max_acceleration_rad_s2;
  demo.arm.limits.max_jerk_rad_s3 = limits.max_jerk_rad_s3;
  EXPECT_EQ(model_hash(demo), model_hash(nominal));
  EXPECT_EQ(demo.controller.period_s, nominal.controller.period_s);
  EXPECT_EQ(demo.camera_hint_T_C_B.p, nominal.camera_hint_T_C_B.p);
}

TEST(ShippedFiles, AnExperimentForAnotherArmIsRefusedWithAllItsFaults) {
  RobotConfig robot = load_robot(kNominal);
  robot.arm.limits.max_rad(0) = 0.5;
  try {
    demo::load_experiment(kHome / "tools/experiments/chapter8.yaml", robot);
    FAIL() << "poses outside the limits were taken";
  } catch (const ConfigError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("commanded_poses_rad"), std::string::npos) << text;
    EXPECT_NE(text.find("must lie inside the robot's limits (joint 1)"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace armsight
