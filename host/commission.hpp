// `host commission`: leads through an arm's new joints one by one, slowly and within 2° of where they stand. An
// operator says what the joint really did; out comes the robot file with sign, scale and zero as they are, its limits
// looked at, the drive's own stop measured. Nothing is written unless every joint asked for is through.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "host/host_io.hpp"
#include "host/operator.hpp"

namespace armsight::host {

struct CommissionOptions {
  std::string robot_file, out_file;
  std::vector<std::size_t> joints;  ///< from 0, in this order
  double tolerance_rad = 0.0035;    ///< how exactly the operator measures angles
};

/// The joints named, or all that are not commissioned. Throws ConfigError for a name that is none or is commissioned.
std::vector<std::size_t> joints_to_commission(const RobotConfig& robot, const std::vector<std::string>& names);
/// With power and lease. Throws CommandFailed naming the joint and what is wrong; the arm then holds where it is.
void run_commission(HostIo& io, Operator& person, const CommissionOptions& options, std::ostream& out);
/// What would be done.
void show_commission(const RobotConfig& robot, const CommissionOptions& options, std::ostream& out);

}  // namespace armsight::host
