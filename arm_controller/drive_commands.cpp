#include "arm_controller/drive_commands.hpp"

#include <array>
#include <cstddef>

namespace armsight::arm {
namespace {

// Columns: not ready, disabled, ready, switched on, enabled, quick stop active, fault reaction, fault, unknown.
// "Disabled" towards power-off goes to ready and waits there: one step from voltage, none from motion.
constexpr std::array<std::array<std::uint16_t, kDriveStates>, kPowerRequests> kCommandTable{{
    /* off */ {kDisableVoltage, kShutdown, kShutdown, kShutdown, kShutdown, kDisableVoltage, kDisableVoltage,
               kDisableVoltage, kDisableVoltage},
    /* on */ {kDisableVoltage, kShutdown, kSwitchOn, kEnableOperation, kEnableOperation, kEnableOperation,
              kDisableVoltage, kDisableVoltage, kDisableVoltage},
    /* quick stop */ {kDisableVoltage, kShutdown, kShutdown, kShutdown, kQuickStop, kQuickStop, kDisableVoltage,
                      kDisableVoltage, kDisableVoltage},
}};
static_assert(static_cast<int>(PowerRequest::kOff) == 0 && static_cast<int>(PowerRequest::kOn) == 1 &&
              static_cast<int>(PowerRequest::kQuickStop) == 2);
static_assert(static_cast<int>(DriveState::kNotReady) == 0 && static_cast<int>(DriveState::kUnknown) == kDriveStates - 1);

}  // namespace

std::uint16_t power_command(PowerRequest request, DriveState state) noexcept {
  return kCommandTable[static_cast<std::size_t>(request)][static_cast<std::size_t>(state)];
}

}  // namespace armsight::arm
