// Act: find the object by its marker, choose a grasp with a certificate, drive to the pre-grasp and the grasp, close,
// and judge by the hand alone. Nothing is grasped blindly: without a sight of the marker nothing moves.
#pragma once

#include <iosfwd>

#include "host/grasp_table.hpp"
#include "host/host_io.hpp"
#include "host/session_files.hpp"

namespace armsight::host {

/// What becomes of the object in the hand: up against gravity, back the way the hand came, or nothing.
enum class AfterGrasp { kLift, kRetreat, kStay };

struct GraspOptions {
  int frames = 7;
  int view_attempts = 6;  ///< postures out of the camera's way that are tried
  AfterGrasp then = AfterGrasp::kLift;
  bool dry_run = false;  ///< looks and plans from where the arm stands; nothing moves
};

/// Writes grasp.json in any case. Throws CommandFailed where the grasp was refused or the hand came back empty.
void run_grasp(HostIo& io, SessionFiles& files, const GraspObject& object, const GraspOptions& options,
               std::ostream& progress);

}  // namespace armsight::host
