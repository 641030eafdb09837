// What counts as having met something. That the arm then stops, leaves off pressing and doubts its model:
// tests/faults, row 18.
#include <gtest/gtest.h>

#include "arm_controller/contact_watch.hpp"
#include "tests/arm_controller/arm_rig.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::arm::test {
namespace {

using armsight::test::joints;

TEST(ContactWatch, AJointIsBehindForAWhileBeforeItHasMetSomething) {
  RobotConfig robot = nominal_robot();
  robot.contact = {0.1, 0.0, 0.04};
  ContactWatch watch(robot);
  const JointVector command = joints({0.9, 0, 0, 1.0, 0}), zero = JointVector::Zero(5);
  JointVector behind = command;
  behind[3] += 0.11;
  for (int k = 0; k < 50; ++k) EXPECT_FALSE(watch.step(command, k % 8 == 7 ? command : behind, zero, zero));
  std::optional<Contact> contact;
  int cycles = 0;
  while (!(contact = watch.step(command, behind, zero, zero)) && cycles < 100) ++cycles;
  EXPECT_LE(cycles, 9) << "0.04 s";
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->joint, 3);
  EXPECT_FALSE(contact->is_torque);
  EXPECT_NEAR(contact->value, 0.11, 1e-12);
}

TEST(ContactWatch, ATorqueIsOneOnlyBeyondWhatHoldsTheArm) {
  RobotConfig robot = nominal_robot();
  robot.contact = {0.0, 1.5, 0.02};
  robot.soft.links[4] = {0.8, {0, 0.05, 0}};
  const JointVector q = joints({0.9, 0, 0, 1.0, 0}), zero = JointVector::Zero(5);
  const JointVector held = gravity_torque(robot.arm.chain, robot.soft.links, robot.gravity_m_s2, q);
  ASSERT_GT(held.cwiseAbs().maxCoeff(), 1.0) << "the weight is worth noticing";
  ContactWatch watch(robot);
  for (int k = 0; k < 50; ++k) EXPECT_FALSE(watch.step(q, q, held, zero));
  JointVector pressed = held;
  pressed[2] += 2.0;
  std::optional<Contact> contact;
  int cycles = 0;
  while (!(contact = watch.step(q, q, pressed, zero)) && cycles < 100) ++cycles;
  EXPECT_EQ(cycles, 4) << "0.02 s";
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->joint, 2);
  EXPECT_TRUE(contact->is_torque);
}

}  // namespace
}  // namespace armsight::arm::test
