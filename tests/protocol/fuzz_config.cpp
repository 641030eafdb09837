// Any text as robot file and as model file: taken or refused, never more.
#include <cmath>
#include <cstdlib>

#include "fuzz.hpp"
#include "protocol/config.hpp"
#include "protocol/model_file.hpp"

using namespace armsight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const RobotConfig robot = parse_robot(text, "robot.yaml");
    if (!robot.arm.limits.max_rad.allFinite() || !std::isfinite(robot.controller.period_s)) std::abort();
  } catch (const ConfigError&) {
  }
  try {
    const ModelFile file = parse_model_file(text, "model.yaml", {"ego_right_arm", 0x7d276dfa309ffa1b, 2});
    if (!is_finite(file.model.T_C_B) || !file.model.beta.allFinite()) std::abort();
  } catch (const ConfigError&) {
  }
  return 0;
}
