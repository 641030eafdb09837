// One MCAP file of the controller: /info once, then /tick, /link and /can (protocol/recording.proto).
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>

#include "arm_controller/tick_tape.hpp"
#include "protocol/arm_link.pb.h"
#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"

namespace armsight::arm {

/// What the tick said and was told, without what no second run can repeat (the time it took): 0.
void to_wire(const CycleRecord& record, wire::TickRecord& out);

class TickRecording {
 public:
  /// Throws std::runtime_error "PATH: cannot be written".
  TickRecording(const std::filesystem::path& file, const wire::RecordingInfo& info);

  void write(const CycleRecord& record);
  void write_frames(std::span<const TapeFrame> frames);
  void write(const wire::CheckpointRecord& checkpoint, Time time);
  void write(const wire::CycleInput& input, Time time);
  void write(const wire::LinkRecord& record);
  void flush() { writer_.flush(); }
  bool is_good() const { return writer_.is_good(); }

 private:
  std::ofstream out_;
  RecordingWriter writer_;
  ChannelId info_, tick_, link_, can_;
  std::optional<ChannelId> state_, input_;  ///< of a black box only
  std::string buffer_;
};

}  // namespace armsight::arm
