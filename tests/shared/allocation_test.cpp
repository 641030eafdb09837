// Nothing that the tick calls may allocate: malloc itself is counted here, since Eigen does not go through operator
// new.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "shared/joint_offset_ekf.hpp"
#include "shared/joint_servo.hpp"
#include "shared/pose_servo.hpp"
#include "tests/shared/default_arm.hpp"
#include "tests/shared/simulated_looks.hpp"

namespace {
std::atomic<long> allocations{0};
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanCount = false;  // the sanitizers own malloc
#else
constexpr bool kCanCount = true;
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif

namespace armsight {
namespace {

using namespace test;

class Allocation : public testing::Test {
 protected:
  const ArmModel arm = default_arm();
  std::mt19937 random{1};
  const JointVector q = joints({0.3, -0.4, 0.5, 1.0, 0.2});

  void SetUp() override {
    if (!kCanCount) GTEST_SKIP() << "the sanitizer owns malloc";
  }
  template <class Work>
  static long allocations_in(Work&& work) {
    const long before = allocations.load();
    work();
    return allocations.load() - before;
  }
};

TEST_F(Allocation, TheCounterCounts) {
  EXPECT_GE(allocations_in([] {
    void* volatile memory = std::malloc(100);
    std::free(memory);
  }), 1);
}

TEST_F(Allocation, KinematicsAllocateNothing) {
  double sum = 0.0;
  const SerialChain chain = general_chain(8, 1);
  const JointVector q8 = JointVector::Constant(8, 0.3);
  EXPECT_EQ(allocations_in([&] {
    sum += hand_kinematics(chain, q8).J.sum() + forward_kinematics(chain, q8).p.sum();
    sum += position_manipulability(chain, q8);
    sum += predict_hand_eye(chain, Pose{}, q8, q8).H.sum();
  }), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST_F(Allocation, FilterAllocatesNothing) {
  const TrueRobot truth = true_robot(random);
  JointOffsetEkf ekf(truth.arm.chain, EkfOptions{});
  const LearnedModel model = disturbed_model(truth, 0.03, 0.07, 0.05, 0.0087, random);
  const HandPoseMeasurement good = look_at(truth, random_visible_posture(truth, random), {}, false, random);
  HandPoseMeasurement outlier = good;
  outlier.T_C_H.p.x() += 1.0;
  outlier.T_C_H_second.p.x() += 1.0;
  FusionOutcome first{}, second{};
  EXPECT_EQ(allocations_in([&] {
    ekf.reset(model);
    ekf.predict(0.004);
    first = ekf.update(good).outcome;
    second = ekf.update(outlier).outcome;
    ekf.predicted_hand_covariance(good.q);
  }), 0);
  EXPECT_NE(first, second);
}

TEST_F(Allocation, FilterOfEightJointsAllocatesNothing) {
  const SerialChain chain = general_chain(8, 1);
  const JointVector zero = JointVector::Zero(8);
  JointOffsetEkf ekf(chain, EkfOptions{});
  HandPoseMeasurement z;
  z.T_C_H = predict_T_C_H(chain, Pose{}, zero, zero);
  z.T_C_H.p.x() += 0.01;
  z.q = zero;
  FusionOutcome outcome{};
  EXPECT_EQ(allocations_in([&] { outcome = ekf.update(z).outcome; }), 0);
  EXPECT_EQ(outcome, FusionOutcome::kFused);
}

TEST_F(Allocation, ServosAllocateNothing) {
  JointServo servo(arm.limits);
  const Pose goal = forward_kinematics(arm.chain, joints({0.5, -0.3, 0.2, 1.2, -0.4}));
  EXPECT_EQ(allocations_in([&] {
    servo.reset(q);
    for (int k = 0; k < 100; ++k) servo.step_towards(arm.limits.max_rad, 0.5, 0.004);
    for (int k = 0; k < 100; ++k) {
      servo.step_with_speed(pose_servo_speeds(arm.chain, servo.setpoint().q_rad, goal, arm.limits.min_rad,
                                              arm.limits.max_rad, arm.limits.max_speed_rad_s, 0.004, {}), 0.004);
    }
    servo.step_to_rest(0.004);
  }), 0);
}

}  // namespace
}  // namespace armsight
