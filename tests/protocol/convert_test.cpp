#include "protocol/convert.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace armsight {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

wire::Pose good_pose() {
  wire::Pose pose;
  pose.set_x_m(0.1);
  pose.set_qw(0.6);
  pose.set_qz(0.8);
  return pose;
}

wire::RefusalReason reason_of(const wire::Pose& in) {
  Pose out;
  const auto refused = from_wire(in, "goal.hand_goal", out);
  if (!refused) return wire::REFUSAL_REASON_UNSPECIFIED;
  EXPECT_EQ(refused->text.rfind("goal.hand_goal: ", 0), 0U) << refused->text;
  EXPECT_TRUE(out.R.isIdentity(0) && out.p.isZero(0)) << "a refused message must leave the target alone";
  return refused->reason;
}

TEST(ConvertPose, ComesBackForRandomPoses) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Pose T;
    const Eigen::Quaterniond quat(normal(random), normal(random), normal(random), normal(random));
    T.R = quat.normalized().toRotationMatrix();
    T.p = {normal(random), normal(random), normal(random)};
    wire::Pose message;
    to_wire(T, &message);
    EXPECT_GE(message.qw(), 0);
    Pose back;
    ASSERT_FALSE(from_wire(message, "pose", back));
    EXPECT_TRUE(back.R.isApprox(T.R, 1e-14));
    EXPECT_EQ(back.p, T.p);
  }
}

TEST(ConvertPose, NamesItsQuaternionParts) {
  Pose T;
  ASSERT_FALSE(from_wire(good_pose(), "pose", T));  // w 0.6, z 0.8: about z by 2 acos 0.6
  EXPECT_NEAR(T.R(0, 0), 0.36 - 0.64, 1e-15);
  EXPECT_NEAR(T.R(1, 0), 2 * 0.6 * 0.8, 1e-15);
}

TEST(ConvertPose, RefusesEveryKindOfBadNumber) {
  for (const double bad : {kNaN, kInf, -kInf}) {
    for (const auto set : {&wire::Pose::set_x_m, &wire::Pose::set_y_m, &wire::Pose::set_z_m, &wire::Pose::set_qw,
                           &wire::Pose::set_qx, &wire::Pose::set_qy, &wire::Pose::set_qz}) {
      wire::Pose pose = good_pose();
      (pose.*set)(bad);
      EXPECT_EQ(reason_of(pose), wire::REFUSAL_REASON_NOT_FINITE);
    }
  }
  wire::Pose far = good_pose();
  far.set_y_m(1e200);
  EXPECT_EQ(reason_of(far), wire::REFUSAL_REASON_OUT_OF_LIMITS);
}

TEST(ConvertPose, RefusesQuaternionsOffUnitLength) {
  EXPECT_EQ(reason_of(wire::Pose()), wire::REFUSAL_REASON_BAD_QUATERNION);  // all zero: an absent pose
  for (const auto& [scale, is_good] : {std::pair(0.9991, true), {1.0009, true}, {0.9989, false}, {1.0011, false}}) {
    wire::Pose pose = good_pose();
    pose.set_qw(0.6 * scale);
    pose.set_qz(0.8 * scale);
    EXPECT_EQ(reason_of(pose), is_good ? wire::REFUSAL_REASON_UNSPECIFIED : wire::REFUSAL_REASON_BAD_QUATERNION)
        << scale;
  }
  wire::Pose huge = good_pose();
  huge.set_qx(1e308);  // its square is beyond double
  EXPECT_EQ(reason_of(huge), wire::REFUSAL_REASON_BAD_QUATERNION);
}

TEST(ConvertJoints, RefusesWrongSizesAndBadNumbers) {
  wire::JointGoal message;
  JointVector q = JointVector::Constant(3, 0.5);
  to_wire(q, message.mutable_q_real_rad());
  JointVector back;
  ASSERT_FALSE(from_wire(message.q_real_rad(), "q_real_rad", 3, back));
  EXPECT_EQ(back, q);
  const auto wrong_size = from_wire(message.q_real_rad(), "q_real_rad", 5, back);
  ASSERT_TRUE(wrong_size);
  EXPECT_EQ(wrong_size->reason, wire::REFUSAL_REASON_MALFORMED);
  EXPECT_EQ(wrong_size->text, "q_real_rad: has 3 values, must have 5");
  message.set_q_real_rad(1, kNaN);
  EXPECT_EQ(from_wire(message.q_real_rad(), "q_real_rad", 3, back)->reason, wire::REFUSAL_REASON_NOT_FINITE);
}

TEST(ConvertCovariance, ComesBackRowMajorAndRefusesWhatIsNoCovariance) {
  StateMatrix P = StateMatrix::Identity(3, 3);
  P(0, 2) = P(2, 0) = 0.25;
  wire::HandPose message;
  const auto refusal = [&](auto change) {
    to_wire(P, message.mutable_covariance());
    change(*message.mutable_covariance());
    StateMatrix back;
    return from_wire(message.covariance(), "covariance", 3, back);
  };
  StateMatrix back;
  to_wire(P, message.mutable_covariance());
  ASSERT_FALSE(from_wire(message.covariance(), "covariance", 3, back));
  EXPECT_EQ(back, P);
  EXPECT_EQ(message.covariance(2), 0.25);
  EXPECT_EQ(refusal([](auto& v) { v.Set(1, 0.1); })->text, "covariance: must be symmetric");
  EXPECT_EQ(refusal([](auto& v) { v.Set(4, -1); })->text, "covariance: variances must not be negative");
  EXPECT_EQ(refusal([](auto& v) { v.Set(0, 1e30); })->reason, wire::REFUSAL_REASON_IMPLAUSIBLE);
  EXPECT_EQ(refusal([](auto& v) { v.Set(0, kInf); })->reason, wire::REFUSAL_REASON_NOT_FINITE);
  EXPECT_EQ(refusal([](auto& v) { v.RemoveLast(); })->reason, wire::REFUSAL_REASON_MALFORMED);
}

}  // namespace
}  // namespace armsight
