// Row 18: something holds a link. The arm stops, leaves off pressing, and nothing else of it goes on; free motion of
// all kinds is never taken for it.
#include <numeric>

#include "tests/faults/fault_rig.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::faults {
namespace {

using arm::FaultCode;

constexpr int kHeld = 0;

/// What the drive of the held joint gave, in permille of its rated torque, a cycle each.
std::vector<double> pressing(FaultRig& rig, int cycles) {
  std::vector<double> torque;
  for (int k = 0; k < cycles; ++k) {
    rig.cycle();
    torque.push_back(std::abs(rig.world->plant().joint_motor(kHeld).torque_permille()));
  }
  return torque;
}

/// From where the arm is now, joint 1 cannot go on.
void block_joint_1(FaultRig& rig) {
  const double q = rig.q_rad()[kHeld];
  rig.world->plant().block(kHeld, q - 3.0, q + 0.02);
}

double pressed_s(const FaultRig& rig, const std::vector<double>& torque, double permille) {
  const auto is_pressing = [permille](double t) { return t > permille; };
  return static_cast<double>(std::ranges::count_if(torque, is_pressing)) * rig.robot.controller.period_s;
}

TEST(HeldLink, StopsTheArmAndIsPressedNoLonger) {
  FaultRig rig;
  ASSERT_TRUE(rig.start_moving());
  const Time began = rig.now;
  block_joint_1(rig);
  const std::vector<double> torque = pressing(rig, 500);
  EXPECT_GT(std::ranges::max(torque), 900.0) << "it pressed";
  const auto& limits = rig.robot.contact;
  EXPECT_LT(pressed_s(rig, torque, 200.0), limits.following_error_rad / 0.5 + limits.time_s + 0.6) << "and left off";
  EXPECT_LT(torque.back(), 60.0);
  EXPECT_TRUE(rig.is_still());
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled)) << "it holds itself";
  EXPECT_LT(rig.travelled_rad(began), 0.5 * (limits.following_error_rad / 0.5 + limits.time_s) + 0.2);
  ASSERT_TRUE(rig.last<arm::StopEvent>());
  EXPECT_EQ(rig.last<arm::StopEvent>()->cause.code, FaultCode::kContact);
  EXPECT_EQ(rig.last<arm::StopEvent>()->cause.sub, kHeld + 1);
}

TEST(HeldLink, IsNoticedSoonerByItsTorque) {
  RobotConfig robot = shipped_robot();
  robot.contact = {};
  robot.contact.torque_Nm = 4.0;
  robot.contact.time_s = 0.02;
  FaultRig rig(robot);
  ASSERT_TRUE(rig.start_moving());
  ASSERT_FALSE(rig.last<arm::StopEvent>()) << "moving alone is no contact";
  block_joint_1(rig);
  const std::vector<double> torque = pressing(rig, 500);
  EXPECT_LT(pressed_s(rig, torque, 200.0), 0.65);
  EXPECT_LT(torque.back(), 60.0);
  EXPECT_TRUE(rig.is_still());
  ASSERT_TRUE(rig.last<arm::StopEvent>());
  EXPECT_EQ(rig.last<arm::StopEvent>()->cause.detail, 1u) << "its torque";
}

TEST(HeldLink, OpensTheFiltersCovariance) {
  struct SureRig : FaultRig {
    arm::StartModel start_model() const override {
      arm::StartModel start = FaultRig::start_model();
      start.P = 1e-8 * StateMatrix::Identity(6 + kJoints, 6 + kJoints);
      return start;
    }
  } rig;
  rig.kill_controller();  // the first one started before it was sure
  rig.start_controller();
  ASSERT_TRUE(rig.start_moving());
  const auto variance = [&] { return rig.last<arm::ModelEvent>()->P(kErrorBeta + 2, kErrorBeta + 2); };
  ASSERT_LT(variance(), 1e-4);
  block_joint_1(rig);
  rig.cycles(300);
  const double sigma = rig.robot.filter.prior_beta_sigma_rad;
  EXPECT_NEAR(variance(), sigma * sigma, 1e-3 * sigma * sigma);
  EXPECT_EQ(rig.state.model.beta.norm(), 0.0) << "what was believed is still the best guess";
}

TEST(HeldLink, GoesOnByCommandWhenItIsFree) {
  FaultRig rig;
  ASSERT_TRUE(rig.start_moving());
  block_joint_1(rig);
  rig.cycles(500);
  ASSERT_TRUE(rig.is_still());
  rig.world->plant().block(kHeld, -3.0, 3.0);
  rig.cycles(200);
  EXPECT_TRUE(rig.is_still()) << "not by itself";
  rig.send_goal(FaultRig::far_goal());
  EXPECT_TRUE(rig.cycle_until([&] { return (rig.q_rad() - FaultRig::far_goal()).norm() < 0.01; }, 2000));
}

TEST(HeldLink, IsNotSeenInMotionsOfAllKinds) {
  FaultRig rig;
  ASSERT_TRUE(rig.power_up());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int goal = 0; goal < 60; ++goal) {
    const JointVector q = test::random_within(rig.robot.arm.limits, random);
    rig.send_goal(q, 0.1 + 0.9 * u(random));
    rig.cycles(static_cast<int>(400 * u(random)));  // mostly replaced under way
  }
  for (const arm::Event& event : rig.events) {
    const auto* stop = std::get_if<arm::StopEvent>(&event);
    EXPECT_FALSE(stop && stop->cause.code == FaultCode::kContact) << arm::fault_text(stop->cause);
  }
}

}  // namespace
}  // namespace armsight::faults
