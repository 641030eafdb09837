// What is asked of a CiA 402 node before it may move, as a table: identity compared, objects written AND read back, in
// the order that drives accept (controller.md §4.3, §4.4). Built once a node, walked by node_start.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "protocol/can_frames.hpp"
#include "protocol/config.hpp"

namespace armsight::arm {

enum class StepKind : std::uint8_t {
  kCompare,    ///< read, (value & mask) must be `value`
  kStore,      ///< read into a slot
  kText,       ///< read a string, for people
  kWrite,      ///< write only: the value is final later in the table
  kWriteBack,  ///< write, read back, must be equal
};

enum class OnAbort : std::uint8_t {
  kFault,
  kSkip,           ///< optional in drives
  kDegrade,        ///< the arm can live without it, but it is told; so it is where another value reads back
  kFallBack,       ///< write `fall_back` instead, and tell
  kShorterRpdo,    ///< the drive has no torque offset: RPDO1 ends after the target
};

/// Values that later decisions need.
enum StoreSlot : std::uint8_t { kEncoderCounts, kEncoderTurns, kGearMotor, kGearShaft, kRatedTorque, kVendor, kProduct, kRevision, kSerial,
                                kStoreSlots };

struct ScriptStep {
  ObjectAddress object;
  std::uint8_t size = 0;
  StepKind kind = StepKind::kWriteBack;
  std::uint32_t value = 0;
  std::uint32_t mask = 0xFFFFFFFF;
  OnAbort on_abort = OnAbort::kFault;
  std::uint32_t fall_back = 0;
  StoreSlot slot = kStoreSlots;
};

struct NodeScript {
  std::array<ScriptStep, 64> steps{};
  std::size_t count = 0;
};

struct ScriptOptions {
  std::uint8_t node = 0;
  std::uint32_t period_us = 4000;
  std::uint16_t rpdo_deadline_ms = 20;
  std::uint16_t controller_heartbeat_ms = 250;  ///< the drive reacts after so long without ours
  std::uint16_t drive_heartbeat_ms = 100;
  DriveMode mode = DriveMode::kCyclicPosition;
  std::uint8_t homing_method = 0;               ///< 0: none
  std::optional<ObjectAddress> stiffness_object;
  std::uint16_t stiffness_permille = 1000;
};

NodeScript make_node_script(const ScriptOptions& options);

}  // namespace armsight::arm
