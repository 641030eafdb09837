// The start-up self-check: what each drive said about itself and what it takes, and where each joint stands against
// where it was last seen. Collected while the drives are configured, told as one page before power goes on
// (controller.md §11.2 no. 6). A refused line has its fault; a degraded one is told and lived with.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "arm_controller/fault.hpp"
#include "protocol/can_frames.hpp"
#include "protocol/config.hpp"

namespace armsight::arm {

enum class Verdict : std::uint8_t { kOk, kDegraded, kRefused };
const char* to_text(Verdict verdict) noexcept;

/// An object that a drive lacks, or that reads back as something else, where the arm can live with it.
struct Shortfall {
  ObjectAddress object;
  std::uint32_t wanted = 0, got = 0;
  std::uint32_t abort_code = 0;  ///< 0: it was taken and reads back as `got`
};

/// Of a DAMIAO drive alone.
struct MitCheck {
  std::uint32_t mode_found = 0, timeout_units = 0, version = 0;
  int turns = 0;  ///< added to what it counts
};

struct NodeCheck {
  static constexpr std::size_t kMaxShortfalls = 8;
  std::uint8_t node = 0;
  DriveFamily family = DriveFamily::kCanopen;
  MitCheck mit;
  DriveMode mode = DriveMode::kCyclicPosition;
  std::uint8_t homing_method = 0;
  bool is_identified = false, is_mapped = false, is_ready = false, has_torque_offset = true;
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;  ///< 0x1018
  std::array<char, 25> name{};                                      ///< 0x1008
  double counts_per_turn = 0.0;
  std::array<Shortfall, kMaxShortfalls> shortfalls{};
  std::size_t shortfall_count = 0;
  Fault fault;
};

/// Where a joint was last seen; nothing is known of one that was never saved.
struct WrapCheck {
  bool is_known = false;
  double last_rad = 0.0, now_rad = 0.0;
  Verdict verdict = Verdict::kDegraded;
};

struct SelfCheck {
  std::array<NodeCheck, kMaxJoints + 1> nodes{};
  int node_count = 0;
  std::array<WrapCheck, kMaxJoints> wraps{};
};

struct CheckLine {
  Verdict verdict = Verdict::kOk;
  std::uint8_t node = 0;
  std::string text;              ///< "reactions: 0x605A:0 wanted 6, has 2"
};

/// Allocates: for the link and the terminal.
std::vector<CheckLine> lines_of(const SelfCheck& check);
Verdict worst_of(const std::vector<CheckLine>& lines);
/// The page.
std::string to_text(const std::vector<CheckLine>& lines);

/// Farther than so from the last position, and near a multiple of a turn of the joint: about a whole turn.
inline constexpr double kWholeTurnSlack_rad = 0.8;
bool is_about_a_whole_turn(double moved_rad) noexcept;

}  // namespace armsight::arm
