// A robot at the rate that the engine of tools/hil carries, and the skip where there is no vcan.
#pragma once

#include <gtest/gtest.h>
#include <net/if.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace armsight::vcan {

inline double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atof(text);
}

inline double rate_hz() { return from_environment("ARMSIGHT_VCAN_RATE_HZ", 250.0); }
/// What a time-out is multiplied with on this engine.
inline double patience() { return from_environment("ARMSIGHT_VCAN_PATIENCE", 1.0); }

inline bool has_vcan() { return if_nametoindex("vcan0") != 0; }
inline bool must_have_vcan() { return from_environment("ARMSIGHT_REQUIRE_VCAN", 0.0) != 0.0; }

/// The shipped robot (0.5 rad/s: a move lasts longer than a program takes to start) with the engine's rate and
/// deadlines that a stalled guest keeps.
inline std::filesystem::path guest_robot(const std::filesystem::path& home, const std::filesystem::path& file) {
  std::ifstream in(home / "arm_controller/config/ego_right_arm.yaml");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto set = [&](const std::string& key, double value) {
    const std::size_t at = text.find(key + ": ") + key.size() + 2;
    text.replace(at, text.find_first_of(" \n", at) - at, std::to_string(value));
  };
  set("period_s", 1.0 / rate_hz());
  set("rpdo_deadline_s", std::min(1.0, 0.1 * patience()));
  set("heartbeat_s", std::min(5.0, 0.25 * patience()));
  set("lease_s", std::min(1.0, 0.2 * patience()));
  std::ofstream(file) << text;
  return file;
}

}  // namespace armsight::vcan

/// A skip is one only where nobody insists: tools/hil says which engine is missing, CI asks for one.
#define ARMSIGHT_NEEDS_VCAN()                                                                     \
  do {                                                                                            \
    if (armsight::vcan::has_vcan()) break;                                                        \
    if (armsight::vcan::must_have_vcan()) FAIL() << "no vcan0, and ARMSIGHT_REQUIRE_VCAN is set"; \
    GTEST_SKIP() << "no vcan0 here: run tools/hil";                                               \
  } while (false)
