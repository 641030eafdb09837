// Where must the arm go so that the camera sees its marker at all? The camera hint gets a few postures; then an even
// sweep over the joint space, with an eye on the way: no knowledge of the camera's place is needed
// (specification F-C2).
#pragma once

#include <iosfwd>
#include <optional>

#include "host/hand_looks.hpp"

namespace armsight::host {

struct FirstSight {
  LookTaken taken;      ///< a look with the arm standing
  int stops = 0;        ///< postures tried
};

/// Moves until a look succeeds. Throws CommandFailed when the whole joint space showed nothing.
FirstSight find_marker(HostIo& io, Looker& looker, int frames, std::ostream& progress);

}  // namespace armsight::host
