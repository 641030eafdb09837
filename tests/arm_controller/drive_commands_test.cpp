// The CiA 402 state machine from both sides, every state × every event, against the table of controller.md §4.4 written
// out here by hand: which controlword the controller sends, and what each controlword's low byte and each statusword
// mean.
#include <gtest/gtest.h>

#include "arm_controller/drive_commands.hpp"
#include "arm_controller/emergency.hpp"

namespace armsight::arm::test {
namespace {

using enum DriveState;

TEST(DriveCommands, EveryStateTimesEveryRequest) {
  struct Row {
    DriveState state;
    int off, on, quick_stop;  // controlword
  };
  const Row table[] = {
      {kNotReady, 0x00, 0x00, 0x00},
      {kSwitchOnDisabled, 0x06, 0x06, 0x06},
      {kReadyToSwitchOn, 0x06, 0x07, 0x06},
      {kSwitchedOn, 0x06, 0x0F, 0x06},
      {kOperationEnabled, 0x06, 0x0F, 0x02},
      {kQuickStopActive, 0x00, 0x0F, 0x02},
      {kFaultReaction, 0x00, 0x00, 0x00},
      {kFault, 0x00, 0x00, 0x00},
      {kUnknown, 0x00, 0x00, 0x00},
  };
  ASSERT_EQ(std::size(table), static_cast<std::size_t>(kDriveStates));
  for (const Row& row : table) {
    EXPECT_EQ(power_command(PowerRequest::kOff, row.state), row.off) << to_text(row.state);
    EXPECT_EQ(power_command(PowerRequest::kOn, row.state), row.on) << to_text(row.state);
    EXPECT_EQ(power_command(PowerRequest::kQuickStop, row.state), row.quick_stop) << to_text(row.state);
  }
}

// All 65536 statuswords: mask 0x4F for not ready, disabled, fault reaction, fault; mask 0x6F for the other four.
TEST(DriveCommands, EveryStatuswordMeansOneState) {
  for (int word = 0; word <= 0xFFFF; ++word) {
    DriveState expected = kUnknown;
    if ((word & 0x4F) == 0x00) expected = kNotReady;
    if ((word & 0x4F) == 0x40) expected = kSwitchOnDisabled;
    if ((word & 0x4F) == 0x0F) expected = kFaultReaction;
    if ((word & 0x4F) == 0x08) expected = kFault;
    if ((word & 0x6F) == 0x21) expected = kReadyToSwitchOn;
    if ((word & 0x6F) == 0x23) expected = kSwitchedOn;
    if ((word & 0x6F) == 0x27) expected = kOperationEnabled;
    if ((word & 0x6F) == 0x07) expected = kQuickStopActive;
    ASSERT_EQ(drive_state(static_cast<std::uint16_t>(word)), expected) << std::hex << word;
  }
}

TEST(Emergency, CodesAndRegisterHaveTheirWords) {
  EXPECT_STREQ(emergency_text(0x2310), "over-current");
  EXPECT_STREQ(emergency_text(0x3210), "DC link over-voltage");
  EXPECT_STREQ(emergency_text(0x3220), "DC link under-voltage");
  EXPECT_STREQ(emergency_text(0x4310), "drive too hot");
  EXPECT_STREQ(emergency_text(0x7306), "sensor error");
  EXPECT_STREQ(emergency_text(0x8110), "CAN overrun: frames lost");
  EXPECT_STREQ(emergency_text(0x8120), "CAN error passive");
  EXPECT_STREQ(emergency_text(0x8130), "heartbeat or life guard lost");
  EXPECT_STREQ(emergency_text(0x8140), "recovered from bus-off");
  EXPECT_STREQ(emergency_text(0x8611), "following error too large");
  EXPECT_STREQ(emergency_text(0xFF17), "vendor-specific error");
  EXPECT_STREQ(emergency_text(0x2399), "current");
  EXPECT_STREQ(emergency_text(0xE000), "unknown error code");
  EXPECT_EQ(error_register_text(0x00), "none");
  EXPECT_EQ(error_register_text(0x21), "generic, device profile");
  EXPECT_EQ(error_register_text(0x90), "communication, vendor");
}

}  // namespace
}  // namespace armsight::arm::test
