#include "tools/sim/arm_sim_flags.hpp"

#include <cstdio>

#include "tools/command_line.hpp"

namespace armsight::sim {

namespace {

constexpr const char* kEmulated = "emulated:";

/// What CLI11 cannot say by itself; empty: all well.
std::string take_bus_and_pace(const std::vector<std::string>& buses, const std::string& pace, ArmSimFlags& flags) {
  if (buses.empty() == flags.can_interfaces.empty()) return "give --bus emulated:PATH or --can IFACE, once a bus";
  for (const std::string& bus : buses) {
    if (!bus.starts_with(kEmulated)) return "--bus " + bus + ": must be emulated:PATH";
    flags.emulated_bus_paths.push_back(bus.substr(std::string(kEmulated).size()));
  }
  const bool is_real_bus = !flags.can_interfaces.empty();
  if (is_real_bus && pace == "lockstep") return "--can implies --pace real: a real bus has its own time";
  flags.is_lockstep = !is_real_bus && pace != "real";
  return {};
}

}  // namespace

std::optional<int> parse_flags(int argc, char** argv, ArmSimFlags& flags) {
  tools::CommandLine line("The simulated robot: drives and hand on a CAN bus, a camera, the truth nobody else knows.",
                          "arm_sim");
  std::string noise = "nominal", mount = "near", pace;
  std::vector<std::string> buses;
  line.add("--robot", flags.robot_file, "robot file (nominal)").required();
  line.add("--scene", flags.scene_file, "scene file (truth)").required();
  line.add("--seed", flags.seed, "which robot, mounts, noise").between(0, 9007199254740991.0).show_default();
  line.add("--noise", noise, "clean | nominal | hard").one_of({"clean", "nominal", "hard"});
  line.add("--pace", pace, "lockstep (default with --bus) | real").one_of({"lockstep", "real"});
  line.add("--bus", buses, "emulated:PATH: serve an emulated bus there; once for each bus of the robot file, in order");
  line.add("--can", flags.can_interfaces, "be on this CAN interface instead, as often; implies --pace real");
  line.add("--clock", flags.clock_path, "socket path of the simulated clock").required();
  line.add("--camera", flags.camera_address, "ADDR:PORT of the camera, port 0: chosen and printed").required();
  line.add("--camera-mount", mount, "near (its nominal mount) | anywhere").one_of({"near", "anywhere"});
  line.add("--rate", flags.rate_hz, "cycles a second, instead of the robot file's").between(1.0, 2000.0);
  line.add("--log", flags.log_file, "write the bus' traffic there as candump -L text");
  if (const auto code = line.parse(argc, argv)) return code;
  flags.noise = *noise_set_from_text(noise);
  flags.mount = mount == "near" ? CameraMount::kNear : CameraMount::kAnywhere;
  const std::string violation = take_bus_and_pace(buses, pace, flags);
  if (violation.empty()) return std::nullopt;
  std::fprintf(stderr, "arm_sim: %s\n", violation.c_str());
  return 2;
}

}  // namespace armsight::sim
