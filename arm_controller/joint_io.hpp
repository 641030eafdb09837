// What passes between the tick and the bus, in the arm's own units: joint samples in, joint set-points out.
#pragma once

#include <array>
#include <cstdint>

#include "arm_controller/fault.hpp"
#include "shared/arm_model.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

enum class BusPhase : std::uint8_t {
  kDown,         ///< not every node has been seen
  kConfiguring,  ///< every node seen, not every one configured
  kReady,        ///< every node configured and reporting, power off or not everywhere on
  kPowered,      ///< every node enabled and following its target
};

struct JointSamples {
  Time time;              ///< sampling instant: our own SYNC on the wire
  bool is_fresh = false;  ///< every joint answered this SYNC; else the values are those of the last complete one
  bool has_positions = false;
  BusPhase phase = BusPhase::kDown;
  Fault fault;            ///< latched by the master until a command says recover
  JointVector q_rad;      ///< encoder readings
  JointVector torque_Nm;
  double hand_closure = 0.0;  ///< 0 open … 1 closed
  double hand_effort_permille = 0.0;
};

/// Of one drive, at its output, before sign and zero.
struct DriveTarget {
  double position_rad = 0.0;
  double bend_rad = 0.0;    ///< what the drive's target lies beyond the link's angle
  double torque_Nm = 0.0;   ///< feed-forward
  std::uint16_t stiffness_permille = 1000, stiffness_goal_permille = 1000;
};

enum class PowerRequest : std::uint8_t { kOff, kOn, kQuickStop };

struct JointCommand {
  PowerRequest power = PowerRequest::kOff;
  bool recover = false;  ///< forget the fault, reset drives, configure again what was lost
  JointVector q_rad;     ///< targets as readings; used only where the phase is kPowered
  JointVector bend_rad;  ///< what a drive's target lies beyond the link's angle (soft joints); empty: nothing
  JointVector torque_Nm; ///< feed-forward at the joints, for drives that take one; empty: nothing
  std::array<std::uint16_t, kMaxJoints> stiffness_permille{}, stiffness_goal_permille{};  ///< now, and where it goes
  double hand_closure = 0.0;
  double hand_goal = 0.0;  ///< where the closure is led to: for a drive that goes there by itself
  std::uint16_t hand_force_permille = 1000;
};

}  // namespace armsight::arm
