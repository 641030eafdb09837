#include "arm_controller/modes.hpp"

#include <cstddef>

namespace armsight::arm {
namespace {

using enum Mode;

// Rows: modes; columns: started, nodes seen, configured, powered, power off, goal, arrived, stop, standstill, fault, clear.
constexpr std::array<std::array<Mode, kModeEvents>, kModes> kTable{{
    {kBusDown, kBoot, kBoot, kBoot, kBoot, kBoot, kBoot, kBoot, kBoot, kFault, kBoot},
    {kBusDown, kConfiguring, kBusDown, kBusDown, kBusDown, kBusDown, kBusDown, kBusDown, kBusDown, kFault, kBusDown},
    {kConfiguring, kConfiguring, kReady, kConfiguring, kConfiguring, kConfiguring, kConfiguring, kConfiguring,
     kConfiguring, kFault, kConfiguring},
    {kReady, kReady, kReady, kHold, kReady, kReady, kReady, kReady, kReady, kFault, kReady},
    {kHold, kHold, kHold, kHold, kReady, kServo, kHold, kHold, kHold, kFault, kHold},
    {kServo, kServo, kServo, kServo, kServo, kServo, kHold, kStopping, kServo, kFault, kServo},
    {kStopping, kStopping, kStopping, kStopping, kStopping, kStopping, kStopping, kStopping, kHold, kFault, kStopping},
    {kFault, kFault, kFault, kFault, kFault, kFault, kFault, kFault, kFault, kFault, kRecovering},
    {kRecovering, kRecovering, kReady, kRecovering, kRecovering, kRecovering, kRecovering, kRecovering, kRecovering,
     kFault, kRecovering},
}};

}  // namespace

const char* to_text(Mode mode) {
  static constexpr std::array<const char*, kModes> kNames{"boot", "bus down", "configuring", "ready", "hold",
                                                          "servo", "stopping", "fault", "recovering"};
  return kNames[static_cast<std::size_t>(mode)];
}

Mode next_mode(Mode mode, ModeEvent event) noexcept {
  return kTable[static_cast<std::size_t>(mode)][static_cast<std::size_t>(event)];
}

}  // namespace armsight::arm
