// The command line of the controller: a handful of flags, read by hand so that the arm computer needs no library for it.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace armsight::arm {

struct Flags {
  bool help = false, require_rt = false;
  std::string config, listen, state;
  std::vector<std::string> can;           ///< SocketCAN interfaces, one a bus of the robot file
  std::vector<std::string> emulated_bus;  ///< or paths
  std::string replay;         ///< black box to go through again, and nothing else
  std::string sim_clock;      ///< path
  double rate_hz = 0.0;       ///< 0: as configured
  std::optional<int> cpu;     ///< of the cycle; none: wherever the system puts it
};

/// Bad flag: exit code 2; what() says which, and which rule.
class FlagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

Flags parse_flags(int argc, const char* const* argv);
extern const char* const kHelp;

}  // namespace armsight::arm
