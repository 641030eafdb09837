// The moving parts and their truth: limits, errors of the right size, fingers that stop on the object only when the
// hand is truly there, everything from the seed.
#include <gtest/gtest.h>

#include <cmath>

#include "shared/kinematics.hpp"
#include "tools/sim/joint.hpp"
#include "tools/sim/plant.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;

const std::string kHome = ARMSIGHT_SOURCE_DIR;

struct Robot : ::testing::Test {
  RobotConfig robot = load_robot(kHome + "/arm_controller/config/ego_right_arm.yaml");
  Scene scene = load_scene(kHome + "/tools/sim/scene.yaml");
  Truth truth(std::uint64_t seed, NoiseSet noise = NoiseSet::kNominal, CameraMount mount = CameraMount::kNear) {
    return make_truth(robot, scene, noise, mount, seed);
  }
};

TEST_F(Robot, TruthComesFromTheSeedAlone) {
  const Truth a = truth(5), b = truth(5), c = truth(6);
  EXPECT_EQ(a.beta, b.beta);
  EXPECT_EQ(a.T_C_B.p, b.T_C_B.p);
  EXPECT_EQ(a.encoder_error[2].at(0.3), b.encoder_error[2].at(0.3));
  EXPECT_NE(a.beta, c.beta);
}

TEST_F(Robot, ErrorsHaveTheFiguresOfTheNoiseSet) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Truth t = truth(seed);
    EXPECT_LE(t.beta.cwiseAbs().maxCoeff(), 8 * kDegree);
    EXPECT_NEAR((t.T_H_M.p - robot.arm.T_H_M.p).norm(), 0.0005, 1e-12);
    EXPECT_NEAR(rotation_angle(t.T_H_M.R, robot.arm.T_H_M.R), 0.3 * kDegree, 1e-9);
    const Pose moved = t.T_C_B * robot.camera_hint_T_C_B.inverse();
    EXPECT_LE(moved.p.norm(), 0.05 + 1e-9);
    EXPECT_LE(rotation_angle(moved.R, Matrix3::Identity()), 10 * kDegree + 1e-9);
    Truth drifted = t;
    inject_drift(drifted);
    const Pose drift = drifted.T_C_B * t.T_C_B.inverse();
    EXPECT_NEAR(drift.p.norm(), 0.015, 1e-9);
    EXPECT_NEAR(rotation_angle(drift.R, Matrix3::Identity()), 3 * kDegree, 1e-9);
    EXPECT_LE((drifted.beta - t.beta).cwiseAbs().maxCoeff(), 2 * kDegree);
  }
  EXPECT_EQ(truth(1, NoiseSet::kClean).servo_residual[0].at(0.2), 0.0);
}

TEST(SmoothErrors, HaveTheirSizeAndForgetOverALook) {
  double sum = 0.0, sum_squares = 0.0, product = 0.0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const SmoothError error(1.0, Random(seed, kForEncoder));
    for (double x = -1.5; x < 1.5; x += 0.1, ++n) {
      sum += error.at(x);
      sum_squares += error.at(x) * error.at(x);
      product += error.at(x) * error.at(x + 0.4);
    }
  }
  EXPECT_NEAR(sum / n, 0.0, 0.05);
  EXPECT_NEAR(sum_squares / n, 1.0, 0.1);
  EXPECT_LT(std::abs(product / n), 0.2);
}

TEST_F(Robot, ACameraAnywhereIsElsewhereAndFound) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Truth t = truth(seed, NoiseSet::kNominal, CameraMount::kAnywhere);
    const Pose moved = t.T_C_B * robot.camera_hint_T_C_B.inverse();
    EXPECT_GT(rotation_angle(moved.R, Matrix3::Identity()), 10 * kDegree);
    EXPECT_TRUE(is_rotation(t.T_C_B.R));
  }
}

TEST_F(Robot, AJointSettlesAtItsTargetWithinSpeedAndResidual) {
  Plant plant(robot, scene, truth(3), Time{});
  Motor& motor = plant.joint_motor(3);
  const std::int32_t start = motor.position_counts();
  const std::int32_t target = start + 1500;
  motor.command(MotorMode::kFollow, target, 1000);
  double fastest = 0.0;
  for (int ms = 1; ms <= 600; ++ms) {
    plant.advance_to(Time{} + ms * 1ms);
    fastest = std::max(fastest, std::abs(plant.speed_rad_s(3)));
  }
  EXPECT_LE(fastest, 6.0);
  const double off_rad = (motor.position_counts() - target) * 2 * std::numbers::pi / 32768;
  EXPECT_LT(std::abs(off_rad), 0.10 * kDegree * 3.5) << "servo residual and jitter";
  EXPECT_LT(std::abs(plant.speed_rad_s(3)), 1e-6);
}

TEST_F(Robot, AJointStopsAtItsMechanicalEndAndOnItsQuickStopRamp) {
  Plant plant(robot, scene, truth(3), Time{});
  plant.joint_motor(1).command(MotorMode::kFollow, 32768, 1000);
  plant.advance_to(Time{} + 3s);
  EXPECT_LE(plant.q_real()[1], robot.arm.limits.max_rad[1] + kMechanicalMargin_rad);
  plant.joint_motor(1).command(MotorMode::kFollow, 0, 1000);
  plant.advance_to(Time{} + 3050ms);
  const double speed = std::abs(plant.speed_rad_s(1)), before = plant.q_real()[1];
  plant.joint_motor(1).command(MotorMode::kStop, 0, 1000);
  plant.advance_to(Time{} + 4s);
  EXPECT_EQ(plant.speed_rad_s(1), 0.0);
  EXPECT_LE(std::abs(plant.q_real()[1] - before), speed * speed / (2 * 20.0) + 0.01);
}

TEST_F(Robot, TheReadingLacksTheOffset) {
  Truth t = truth(3, NoiseSet::kClean);
  const double real = t.start_rad[2], beta = t.beta[2], error = t.encoder_error[2].at(real);
  Plant plant(robot, scene, t, Time{});
  const double reading = plant.joint_motor(2).position_counts() * 2 * std::numbers::pi / 32768;
  EXPECT_NEAR(reading, real - beta - error, 1.01e-4) << "half a count";
}

TEST_F(Robot, TheViewInterpolatesAndHoldsTheEnds) {
  Plant plant(robot, scene, truth(3), Time{});
  plant.joint_motor(0).command(MotorMode::kFollow, 3000, 1000);
  plant.advance_to(Time{} + 80ms);
  const Vector3 a = plant.view(0.040).T_B_H.p, middle = plant.view(0.0405).T_B_H.p, b = plant.view(0.041).T_B_H.p;
  EXPECT_LT((middle - 0.5 * (a + b)).norm(), 1e-5);
  EXPECT_EQ(plant.view(9.0).T_B_H.p, plant.T_B_H().p);
  EXPECT_EQ(plant.view(-1.0).T_B_H.p, plant.view(0.0).T_B_H.p);
}

TEST(NearestGrasp, MeasuresFromAnyYawAndBothSides) {
  const Vector3 centre_H(0.035, -0.060, 0.0);
  const Pose T_B_O{so3_exp({0.2, -0.1, 0.4}), {0.1, -0.2, 0.05}};
  for (const double yaw : {0.0, 1.0, -2.5})
    for (const double flip : {0.0, std::numbers::pi}) {
      Pose T_O_H{so3_exp({0, 0, yaw}) * so3_exp({flip, 0, 0}), Vector3::Zero()};
      T_O_H.p = -(T_O_H.R * centre_H);
      const Pose hand = T_B_O * T_O_H;
      EXPECT_LT(nearest_grasp(hand, T_B_O, centre_H).error_m, 1e-12);
      EXPECT_LT(nearest_grasp(hand, T_B_O, centre_H).error_rad, 1e-7);
      Pose off = hand;
      off.p += Vector3(0, 0, 0.003);
      EXPECT_NEAR(nearest_grasp(off, T_B_O, centre_H).error_m, 0.003, 1e-9);
      Pose tilted = hand;
      tilted.R = so3_exp(0.05 * hand.R.col(0)) * hand.R;
      EXPECT_NEAR(nearest_grasp(tilted, T_B_O, centre_H).error_rad, 0.05, 1e-9);
    }
}

/// Closes the hand with the object moved to (or `miss_m` beside) where the hand would hold it.
struct Closed {
  double closure, effort;
  std::size_t grasps;
  bool is_held;
};
Closed close_hand(const RobotConfig& robot, const Scene& scene, Truth truth, double miss_m) {
  const Pose T_B_H = forward_kinematics(truth.chain, truth.start_rad);
  truth.T_B_O = T_B_H * Pose{Matrix3::Identity(), scene.grasp.centre_H + Vector3(miss_m, 0, 0)};
  Plant plant(robot, scene, truth, Time{});
  plant.hand_motor().command(MotorMode::kFollow, 16000, 400);
  plant.advance_to(Time{} + 2s);
  return {plant.hand_closure(), static_cast<double>(plant.hand_motor().torque_permille()), plant.grasps().size(),
          plant.grasps().at(0).is_held};
}

TEST_F(Robot, FingersStopOnTheObjectOnlyWhenTheHandIsThere) {
  const Closed held = close_hand(robot, scene, truth(4), 0.009);
  EXPECT_NEAR(held.closure, 0.55, 0.01);
  EXPECT_NEAR(held.effort, 400.0, 5.0) << "rises to the grip limit";
  EXPECT_TRUE(held.is_held);
  EXPECT_EQ(held.grasps, 1u);
  const Closed missed = close_hand(robot, scene, truth(4), 0.011);
  EXPECT_NEAR(missed.closure, 1.0, 1e-6);
  EXPECT_LT(missed.effort, 100.0);
  EXPECT_FALSE(missed.is_held);
}

}  // namespace
}  // namespace armsight::sim
