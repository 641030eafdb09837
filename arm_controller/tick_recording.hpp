// One MCAP file of the controller: /info once, then /tick, /link and /can (protocol/recording.proto).
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "arm_controller/tick_tape.hpp"
#include "protocol/arm_link.pb.h"
#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"

namespace armsight::arm {

class TickRecording {
 public:
  /// Throws std::runtime_error "PATH: cannot be written".
  TickRecording(const std::filesystem::path& file, const wire::RecordingInfo& info);

  void write(const TickRecord& record);
  void write_frames(const TickRecord& record);
  void write(const wire::LinkRecord& record);
  void flush() { writer_.flush(); }
  bool is_good() const { return writer_.is_good(); }

 private:
  std::ofstream out_;
  RecordingWriter writer_;
  ChannelId info_, tick_, link_, can_;
  std::string buffer_;
};

}  // namespace armsight::arm
