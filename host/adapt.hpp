// Adapt: a few looks at the hand, each fused by the controller's filter as it comes; the model it answers with plans
// the next look. specification F-F6.
#pragma once

#include <iosfwd>

#include "host/host_io.hpp"
#include "host/session_files.hpp"

namespace armsight::host {

struct AdaptOptions {
  int looks = 5;
  int max_attempts = 12;
  int frames = 5;
  double target_sigma_m = 0.0;  ///< stop early when the hand is better known than this; 0: never
};

/// Throws CommandFailed when not one look was fused; adapt.json is written in any case.
void run_adapt(HostIo& io, SessionFiles& files, const AdaptOptions& options, std::ostream& progress);

}  // namespace armsight::host
