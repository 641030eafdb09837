// Act: find the object by its marker, choose a grasp with a certificate, drive to the pre-grasp and the grasp, close,
// and judge by the hand alone. Nothing is grasped blindly: without a sight of the marker nothing moves.
#pragma once

#include <iosfwd>

#include "host/grasp_table.hpp"
#include "host/host_io.hpp"
#include "host/session_files.hpp"

namespace armsight::host {

struct GraspOptions {
  int frames = 7;
  int view_attempts = 6;  ///< postures out of the camera's way that are tried
};

/// Writes grasp.json in any case. Throws CommandFailed where the grasp was refused or the hand came back empty.
void run_grasp(HostIo& io, SessionFiles& files, const GraspObject& object, const GraspOptions& options, std::ostream& progress);

}  // namespace armsight::host
