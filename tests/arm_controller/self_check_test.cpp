// What the start-up self-check finds wanting is told and lived with, or refused; and nothing is powered before.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/arm_controller/arm_rig.hpp"

namespace armsight::arm::test {
namespace {

std::string page_of(ArmRig& rig) {
  const auto check = rig.mailboxes.self_check.take();
  return check ? to_text(lines_of(*check)) : "";
}

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(SelfCheckPage, TellsEveryNodeOnceBeforePowerGoesOn) {
  ArmRig rig;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  const std::string page = page_of(rig);
  for (FakeDrive& drive : rig.bus.drives()) EXPECT_NE(drive.state, DriveState::kOperationEnabled);
  EXPECT_EQ(count(page, "identity:"), 6) << page;
  EXPECT_EQ(count(page, "mapping: written and read back"), 6) << page;
  EXPECT_EQ(count(page, "units: 32768 counts a turn, cyclic position"), 6) << page;
  EXPECT_EQ(count(page, "not compared: none was saved"), 5) << page;
  EXPECT_LE(count(page, "\n"), 60) << "one page";
  rig.cycles(100);
  EXPECT_EQ(page_of(rig), "") << "once";
}

struct Lack {
  const char* name;
  std::uint32_t object;
  const char* line;
};

class SelfCheckDegrades : public testing::TestWithParam<Lack> {};

TEST_P(SelfCheckDegrades, WhereADriveLacksIt) {
  ArmRig rig;
  rig.bus.drive(2).missing.insert(GetParam().object);
  ASSERT_TRUE(rig.power_up()) << fault_text(rig.state.fault);
  const std::string page = page_of(rig);
  EXPECT_EQ(count(page, "DEGRADED  reactions: " + std::string(GetParam().line) + " refused: no such object"), 1)
      << page;
}

INSTANTIATE_TEST_SUITE_P(Reactions, SelfCheckDegrades,
                         testing::Values(Lack{"AbortConnection", 0x600700, "0x6007:0 wanted 3,"},
                                         Lack{"FaultReaction", 0x605E00, "0x605E:0 wanted 2,"},
                                         Lack{"Deadline", 0x140005, "0x1400:5 wanted 18,"},
                                         Lack{"Heartbeat", 0x101601, "0x1016:1 wanted 8323322,"}),
                         [](const auto& one) { return one.param.name; });

TEST(SelfCheckPage, DegradesADeadlineThatReadsBackAsAnotherValue) {
  ArmRig rig;
  rig.bus.drive(2).stuck[0x140005] = 0;
  ASSERT_TRUE(rig.bring_to(Mode::kReady));
  EXPECT_EQ(count(page_of(rig), "0x1400:5 wanted 18, reads back 0"), 1);
}

TEST(SelfCheckPage, RefusesADriveThatWouldNotNoticeOurDeath) {
  ArmRig rig;
  rig.bus.drive(2).missing = {0x140005, 0x101601};
  ASSERT_TRUE(rig.bring_to(Mode::kFault));
  EXPECT_EQ(rig.state.fault.code, FaultCode::kNoSupervision);
  rig.cycles(200);
  const std::string page = page_of(rig);
  EXPECT_EQ(count(page, "REFUSED   reactions: node 2:"), 1) << page;
  EXPECT_EQ(count(page, "the arm is not enabled"), 1) << page;
  rig.order_mode(PowerWish::kHold, true);
  rig.cycles(400);
  EXPECT_EQ(rig.state.mode, Mode::kFault) << "cleared, looked at again, refused again";
  for (FakeDrive& drive : rig.bus.drives()) EXPECT_NE(drive.state, DriveState::kOperationEnabled);
}

TEST(SelfCheckPage, NamesNodeObjectWantedAndGotOfAMappingThatReadsBackDifferently) {
  ArmRig rig;
  rig.bus.drive(4).stuck[0x1A0002] = 0x606C0020;
  ASSERT_TRUE(rig.bring_to(Mode::kFault));
  EXPECT_EQ(fault_text(rig.state.fault), "node 4: wrote 0x60640020 to 0x1A00:2, read back 0x606C0020");
  rig.cycles(200);
  EXPECT_EQ(count(page_of(rig), "REFUSED   mapping: node 4:"), 1);
}

TEST(SelfCheckPage, RefusesANodeThatDoesNotReport) {
  ArmRig rig;
  rig.bus.drive(3).sends_feedback = false;
  ASSERT_TRUE(rig.bring_to(Mode::kFault));
  rig.cycles(200);
  EXPECT_EQ(count(page_of(rig), "REFUSED   reports: node 3: third TPDO1 in a row missing, last seen never"), 1);
}

/// A rig whose controller knows where the arm was last seen: q as it stands, but joint 4 moved so far since.
void know_last_position(ArmRig& rig, double joint_4_moved_rad) {
  StartModel start = nominal_start(rig.robot);
  start.last_seen_rad = JointVector(5);
  *start.last_seen_rad << 0.2, -0.1, -0.2, 0.8, 0.1;
  (*start.last_seen_rad)[3] -= joint_4_moved_rad;
  rig.loop = std::make_unique<ControlLoop>(rig.robot, start, rig.bus, rig.mailboxes, rig.tape, rig.statistics);
}

TEST(SelfCheckWrap, AJointThatWasMovedByHandIsNoWrap) {
  ArmRig rig;
  know_last_position(rig, 1.0);
  ASSERT_TRUE(rig.power_up());
  EXPECT_EQ(count(page_of(rig), " deg from where it was last seen"), 5);
}

TEST(SelfCheckWrap, AWholeTurnIsRefusedWithTheFigure) {
  for (const double turns : {1.0, -1.0, 2.0}) {
    ArmRig rig;
    know_last_position(rig, turns * 2.0 * std::numbers::pi + 0.05);
    ASSERT_TRUE(rig.bring_to(Mode::kFault));
    EXPECT_EQ(rig.state.fault.code, FaultCode::kWholeTurn);
    EXPECT_EQ(rig.state.fault.node, 4);
    EXPECT_NEAR(rig.state.fault.moved_rad, turns * 2.0 * std::numbers::pi + 0.05, 1e-3);
    rig.cycles(10);
    EXPECT_EQ(count(page_of(rig), "about a whole turn"), 1);
  }
}

TEST(SelfCheckWrap, ADriveThatRebootedATurnOffIsRefusedToo) {
  ArmRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.bus.drive(4).sends_heartbeat = false;
  ASSERT_TRUE(rig.bring_to(Mode::kFault, 100));
  rig.bus.drive(4).position_counts -= 32768.0;
  rig.bus.drive(4).sends_heartbeat = true;
  rig.order_mode(PowerWish::kHold, true);
  ASSERT_TRUE(rig.cycle_until([&] { return rig.state.fault.code == FaultCode::kWholeTurn; }, 2000))
      << fault_text(rig.state.fault);
}

}  // namespace
}  // namespace armsight::arm::test
