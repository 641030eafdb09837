// The third thread, low in priority: alone it touches files. It drains the tape of the cycle into ticks.mcap, keeps the
// last kKeptTicks for the black box, and saves the model in force (atomically) before the link publishes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "arm_controller/messages.hpp"
#include "arm_controller/tick_tape.hpp"
#include "protocol/arm_link.pb.h"
#include "protocol/config.hpp"

namespace armsight::arm {

class FileWriter {
 public:
  /// Touches nothing yet: what is posted before begin() waits.
  FileWriter(const std::filesystem::path& state_folder, const RobotConfig& robot, const std::string& bus,
             const std::string& configuration, Tape& tape);
  ~FileWriter();
  /// Moves the last recording aside and starts a new one; throws std::runtime_error where that cannot be.
  void begin(Time now);

  // Link thread only; none waits for the disk. Of the models that were not saved yet the newest is.
  void save_model(const ModelEvent& model);
  void record_link(bool to_controller, const std::string& peer, const wire::Envelope& envelope, Time now);
  /// All revisions up to this one are on disk.
  std::uint64_t saved_revision() const;
  /// True once for each model that could not be saved (or for several at once).
  bool take_save_failure();
  /// A recording, a black box or the last position could not be written; each file is said once on stderr.
  bool recording_is_broken() const;
  /// Messages of the link that found no room on the way to ticks.mcap; the first is said on stderr.
  std::uint64_t link_records_lost() const;
  /// The newest black box; empty: none was written by this run.
  std::filesystem::path newest_black_box() const;
  /// Returns when everything queued so far is done.
  void wait_idle();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace armsight::arm
