// The controller's modes and what changes them (controller.md §8.3), as one table that a test walks whole.
//
//   Boot ─► BusDown ─► Configuring ─► Ready ⇄ Hold ─► Servo ─► Stopping
//                                       ▲       ▲ ◄────┘ arrived   │ standstill
//                                       │       └──────────────────┘
//   any ── fault ──► Fault ── clear ──► Recovering ──► Ready
#pragma once

#include <array>
#include <cstdint>

namespace armsight::arm {

enum class Mode : std::uint8_t {
  kBoot, kBusDown, kConfiguring, kReady, kHold, kServo, kStopping, kFault, kRecovering
};
inline constexpr int kModes = 9;

enum class ModeEvent : std::uint8_t {
  kStarted,      ///< first tick
  kNodesSeen,    ///< every node answered
  kConfigured,   ///< every node configured and reporting
  kPowered,      ///< every drive enabled and following, as asked
  kPowerOff,     ///< asked for
  kGoal,         ///< a goal was accepted
  kArrived,
  kStop,         ///< Stop, lease lost, goal given up
  kStandstill,
  kFault,
  kClearFault,
};
inline constexpr int kModeEvents = 11;

const char* to_text(Mode mode);

/// The mode after an event; the same mode: the event means nothing there.
Mode next_mode(Mode mode, ModeEvent event) noexcept;

}  // namespace armsight::arm
