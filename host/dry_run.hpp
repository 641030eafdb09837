// --dry-run: what a verb would do, from where the arm stands now. Needs no lease, commands nothing. Throws
// CommandFailed where the controller would refuse the motion.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>

#include "host/host_io.hpp"

namespace armsight::host {

void show_move(HostIo& io, const std::string& verb, const JointVector& q_real, const std::optional<Pose>& T_B_G,
               std::ostream& out);
void show_hand(HostIo& io, double closure, double force_permille, std::ostream& out);
/// The looks that calibrate (by the camera hint, until a first look knows better) or adapt would begin with.
void show_looks(HostIo& io, const std::string& verb, int looks, std::ostream& out);

}  // namespace armsight::host
