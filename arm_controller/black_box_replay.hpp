// A black box gone through again by the executable that wrote it: from its checkpoint on, every cycle is given the
// recorded inputs (frames, messages, times, what the bus refused) and nothing else; frames sent and states are computed
// anew and compared, bit by bit, with the recorded ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

namespace armsight::arm {

/// This file cannot be gone through by this executable; what() says why: exit code 2.
class NotReplayable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct BlackBoxResult {
  std::uint64_t cycles = 0, frames_compared = 0;
  std::optional<std::string> difference;  ///< the first: "cycle 2017: …"; the replay ended there
};

/// Throws NotReplayable, RecordingError.
BlackBoxResult replay_black_box(const std::filesystem::path& file);

}  // namespace armsight::arm
