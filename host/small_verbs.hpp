// The small verbs: move, park, hand, blackbox, stop. Each a plain function over an open HostIo.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "host/host_io.hpp"
#include "host/session_files.hpp"

namespace armsight::host {

/// To a posture (real angles) or, with T_B_G, to a pose of the hand in B. Writes move.json; throws CommandFailed when
/// the arm did not get there.
void run_move(HostIo& io, SessionFiles& files, const JointVector& q_real, const std::optional<Pose>& T_B_G,
              std::ostream& progress);
inline constexpr double kMovePoseOrientation_rad = 0.02;  ///< a pose goal whose best posture is worse is refused
void run_hand(HostIo& io, double closure, double force_permille, std::ostream& progress);
/// One for all or one a joint, ‰. Throws ConfigError; so for an arm none of whose drives can be told.
std::vector<std::uint32_t> stiffness_of(const std::vector<double>& permille, const RobotConfig& robot);
/// Without power, too. Names the joints that stay as they are.
void run_stiffness(HostIo& io, const std::vector<std::uint32_t>& permille, std::ostream& out);
/// The controller's newest black box into a file; needs no lease. Throws CommandFailed where there is none.
void run_black_box(HostIo& io, const std::filesystem::path& file, std::ostream& out);
/// Needs no lease, no robot and no session: it is the first message after Hello.
void run_stop(HostIo& io, std::ostream& out);

}  // namespace armsight::host
