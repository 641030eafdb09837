// Learn, by itself: find the marker, guess, plan looks where the guess says it is visible, look, guess better; then the
// batch solution with its own judgement, saved and proposed to the controller. specification F-C6, F-C8.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "host/host_io.hpp"
#include "host/session_files.hpp"

namespace armsight::host {

struct CalibrateOptions {
  std::filesystem::path robot_file;  ///< goes into the data set of the looks
  int looks = 20;
  int max_attempts = 40;
  int frames = 5;
  double target_sigma_m = 0.0;  ///< stop early when the predicted hand position is better known than this; 0: never
};

/// Throws CommandFailed where no calibration came out that may be used; calibrate.json says why.
void run_calibrate(HostIo& io, SessionFiles& files, const CalibrateOptions& options, std::ostream& progress);

}  // namespace armsight::host
