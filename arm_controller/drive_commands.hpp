// Which controlword leads a CiA 402 drive from where it is to where the arm wants it, as one table (controller.md §4.4).
#pragma once

#include "arm_controller/joint_io.hpp"
#include "protocol/can_frames.hpp"

namespace armsight::arm {

inline constexpr int kDriveStates = 9;
inline constexpr int kPowerRequests = 3;

/// What to send in this state. Quick stop active → enable is transition 16, which some drives lack (node_power).
std::uint16_t power_command(PowerRequest request, DriveState state) noexcept;

}  // namespace armsight::arm
