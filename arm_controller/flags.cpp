#include "arm_controller/flags.hpp"

#include <cmath>
#include <cstdlib>
#include <map>
#include <string_view>

#include "protocol/transport/framed_stream.hpp"

namespace armsight::arm {

const char* const kHelp =
    "arm_controller: drives an arm on a CAN bus for one commanding host.\n"
    "\n"
    "  arm_controller --config FILE --listen ADDR:PORT --state DIR (--can IFACE | --bus emulated:PATH) [options]\n"
    "\n"
    "  --config FILE          robot file (arm_controller/config/ego_right_arm.yaml)\n"
    "  --listen ADDR:PORT     loopback only; port 0: the system chooses, the program prints it\n"
    "  --state DIR            model in force, recordings, black boxes\n"
    "  --can IFACE            SocketCAN interface; implies real pace; once for each bus of the robot file, in order\n"
    "  --bus emulated:PATH    bus of a running arm_sim; as often\n"
    "  --clock sim:PATH       simulated clock of that arm_sim; without it: this machine's\n"
    "  --rate HZ              instead of the configured period; what the bus cannot carry is refused (can_budget)\n"
    "  --replay FILE          go through a black box of this very executable again, alone: same (0) or different (1)\n"
    "  --cpu N                CPU of the cycle, best an isolated one\n"
    "  --require-rt           refuse to run without SCHED_FIFO, locked memory and the CPU of --cpu\n"
    "  --help\n"
    "\n"
    "Exit codes: 0 left as asked, 1 gave up (a mistake of ours), 2 bad flag, file or configuration, 3 bus or simulated clock lost.\n";

namespace {

std::string after_prefix(const std::string& flag, const std::string& value, std::string_view prefix) {
  if (value.size() <= prefix.size() || value.compare(0, prefix.size(), prefix) != 0)
    throw FlagError(flag + " " + value + ": must be " + std::string(prefix) + "PATH");
  return value.substr(prefix.size());
}

double rate(const std::string& value) {
  char* end = nullptr;
  const double hz = std::strtod(value.c_str(), &end);
  if (*end != '\0' || !std::isfinite(hz) || hz < 50.0 || hz > 1000.0)
    throw FlagError("--rate " + value + ": must be a number in [50, 1000]");
  return hz;
}

int cpu_number(const std::string& value) {
  char* end = nullptr;
  const long cpu = std::strtol(value.c_str(), &end, 10);
  if (*end != '\0' || cpu < 0 || cpu > 1023) throw FlagError("--cpu " + value + ": must be a number in [0, 1023]");
  return static_cast<int>(cpu);
}

// What the name means is settled once, here: a second look-up might answer otherwise.
std::string loopback(const std::string& address) {
  try {
    return net::loopback_address(address);
  } catch (const std::exception& e) {
    throw FlagError("--listen " + address + ": " + e.what() + "; the link has no encryption yet and is offered on " +
                    "loopback only (127.0.0.1:PORT); reach it from elsewhere through an ssh tunnel");
  }
}

void check(Flags& flags) {
  if (!flags.replay.empty()) return;  // touches no bus, no socket, no state
  const auto need = [](const std::string& value, const char* flag) {
    if (value.empty()) throw FlagError(std::string(flag) + " is missing (see --help)");
  };
  need(flags.config, "--config");
  need(flags.listen, "--listen");
  need(flags.state, "--state");
  if (flags.can.empty() == flags.emulated_bus.empty())
    throw FlagError("exactly one of --can IFACE and --bus emulated:PATH is needed, once a bus (see --help)");
  if (!flags.can.empty() && !flags.sim_clock.empty())
    throw FlagError("--clock sim:PATH: a CAN interface runs at real pace only");
  flags.listen = loopback(flags.listen);
}

}  // namespace

Flags parse_flags(int argc, const char* const* argv) {
  Flags flags;
  const std::map<std::string, std::string*> texts{
      {"--config", &flags.config}, {"--listen", &flags.listen}, {"--state", &flags.state},
      {"--replay", &flags.replay}};
  for (int i = 1; i < argc; ++i) {
    std::string flag = argv[i], value;
    if (flag == "--help") {
      flags.help = true;
      return flags;
    }
    if (flag == "--require-rt") {
      flags.require_rt = true;
      continue;
    }
    if (const std::size_t equals = flag.find('='); equals != std::string::npos) {
      value = flag.substr(equals + 1);
      flag.resize(equals);
    } else if (i + 1 < argc) {
      value = argv[++i];
    }
    const auto text = texts.find(flag);
    const bool is_known = text != texts.end() || flag == "--can" || flag == "--bus" || flag == "--clock" || flag == "--rate" ||
                          flag == "--cpu";
    if (!is_known) throw FlagError(flag + ": unknown flag (see --help)");
    if (value.empty()) throw FlagError(flag + ": needs a value");
    if (text != texts.end()) *text->second = value;
    if (flag == "--can") flags.can.push_back(value);
    if (flag == "--bus") flags.emulated_bus.push_back(after_prefix(flag, value, "emulated:"));
    if (flag == "--clock") flags.sim_clock = after_prefix(flag, value, "sim:");
    if (flag == "--rate") flags.rate_hz = rate(value);
    if (flag == "--cpu") flags.cpu = cpu_number(value);
  }
  check(flags);
  return flags;
}

}  // namespace armsight::arm
