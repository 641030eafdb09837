#include "tools/sim/arm_sim_flags.hpp"

#include <cstdio>

#include "host/parse_flags.hpp"

namespace armsight::sim {

namespace {

constexpr const char* kEmulated = "emulated:";

/// What CLI11 cannot say by itself; empty: all well.
std::string take_bus_and_pace(const std::string& bus, const std::string& pace, ArmSimFlags& flags) {
  if (bus.empty() == flags.can_interface.empty()) return "give one of --bus emulated:PATH and --can IFACE";
  if (!bus.empty() && !bus.starts_with(kEmulated)) return "--bus " + bus + ": must be emulated:PATH";
  if (!bus.empty()) flags.emulated_bus_path = bus.substr(std::string(kEmulated).size());
  const bool is_real_bus = !flags.can_interface.empty();
  if (is_real_bus && pace == "lockstep") return "--can implies --pace real: a real bus has its own time";
  flags.is_lockstep = !is_real_bus && pace != "real";
  return {};
}

}  // namespace

std::optional<int> parse_flags(int argc, char** argv, ArmSimFlags& flags) {
  CLI::App app("The simulated robot: drives and hand on a CAN bus, a camera, the truth nobody else knows.", "arm_sim");
  std::string noise = "nominal", mount = "near", pace, bus;
  app.add_option("--robot", flags.robot_file, "robot file (nominal)")->required();
  app.add_option("--scene", flags.scene_file, "scene file (truth)")->required();
  app.add_option("--seed", flags.seed, "which robot, mounts, noise")->capture_default_str();
  app.add_option("--noise", noise, "clean | nominal | hard")->check(CLI::IsMember({"clean", "nominal", "hard"}));
  app.add_option("--pace", pace, "lockstep (default with --bus) | real")->check(CLI::IsMember({"lockstep", "real"}));
  app.add_option("--bus", bus, "emulated:PATH: serve an emulated bus there");
  app.add_option("--can", flags.can_interface, "be on this CAN interface instead; implies --pace real");
  app.add_option("--clock", flags.clock_path, "socket path of the simulated clock")->required();
  app.add_option("--camera", flags.camera_address, "ADDR:PORT of the camera, port 0: chosen and printed")->required();
  app.add_option("--camera-mount", mount, "near (its nominal mount) | anywhere")
      ->check(CLI::IsMember({"near", "anywhere"}));
  app.add_option("--rate", flags.rate_hz, "cycles a second, instead of the robot file's")
      ->check(CLI::Range(1.0, 2000.0));
  app.add_option("--log", flags.log_file, "write the bus' traffic there as candump -L text");
  if (const auto code = host::parse_flags(app, argc, argv)) return code;
  flags.noise = *noise_set_from_text(noise);
  flags.mount = mount == "near" ? CameraMount::kNear : CameraMount::kAnywhere;
  const std::string violation = take_bus_and_pace(bus, pace, flags);
  if (violation.empty()) return std::nullopt;
  std::fprintf(stderr, "arm_sim: %s\n", violation.c_str());
  return 2;
}

}  // namespace armsight::sim
