// Every mode × every event, written out. A change of the table must be made twice, on purpose.
#include <gtest/gtest.h>

#include "arm_controller/modes.hpp"

namespace armsight::arm {
namespace {

struct Row { Mode from; ModeEvent event; Mode to; };

// All transitions that change the mode; whatever is not listed must leave it alone.
constexpr Row kTransitions[] = {
    {Mode::kBoot, ModeEvent::kStarted, Mode::kBusDown},
    {Mode::kBusDown, ModeEvent::kNodesSeen, Mode::kConfiguring},
    {Mode::kConfiguring, ModeEvent::kConfigured, Mode::kReady},
    {Mode::kReady, ModeEvent::kPowered, Mode::kHold},
    {Mode::kHold, ModeEvent::kPowerOff, Mode::kReady},
    {Mode::kHold, ModeEvent::kGoal, Mode::kServo},
    {Mode::kServo, ModeEvent::kArrived, Mode::kHold},
    {Mode::kServo, ModeEvent::kStop, Mode::kStopping},
    {Mode::kStopping, ModeEvent::kStandstill, Mode::kHold},
    {Mode::kFault, ModeEvent::kClearFault, Mode::kRecovering},
    {Mode::kRecovering, ModeEvent::kConfigured, Mode::kReady},
    {Mode::kBoot, ModeEvent::kFault, Mode::kFault},
    {Mode::kBusDown, ModeEvent::kFault, Mode::kFault},
    {Mode::kConfiguring, ModeEvent::kFault, Mode::kFault},
    {Mode::kReady, ModeEvent::kFault, Mode::kFault},
    {Mode::kHold, ModeEvent::kFault, Mode::kFault},
    {Mode::kServo, ModeEvent::kFault, Mode::kFault},
    {Mode::kStopping, ModeEvent::kFault, Mode::kFault},
    {Mode::kRecovering, ModeEvent::kFault, Mode::kFault},
};

Mode expected(Mode from, ModeEvent event) {
  for (const Row& row : kTransitions)
    if (row.from == from && row.event == event) return row.to;
  return from;
}

TEST(Modes, FollowTheTableForEveryModeAndEvent) {
  for (int m = 0; m < kModes; ++m)
    for (int e = 0; e < kModeEvents; ++e) {
      const Mode from = static_cast<Mode>(m);
      const ModeEvent event = static_cast<ModeEvent>(e);
      EXPECT_EQ(next_mode(from, event), expected(from, event)) << to_text(from) << ", event " << e;
    }
}

TEST(Modes, LeaveFaultByAnExplicitClearOnly) {
  for (int e = 0; e < kModeEvents; ++e) {
    const bool leaves = next_mode(Mode::kFault, static_cast<ModeEvent>(e)) != Mode::kFault;
    EXPECT_EQ(leaves, static_cast<ModeEvent>(e) == ModeEvent::kClearFault);
  }
}

}  // namespace
}  // namespace armsight::arm
