// Recordings changed on purpose, to see that it is noticed.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"

namespace armsight::replay {

/// A copy in which `change` had its way with every message of the link.
inline void copy_recording(const std::filesystem::path& from, const std::filesystem::path& to,
                           const std::function<void(wire::LinkRecord&)>& change) {
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  RecordingReader reader(in);
  RecordingWriter writer(out, {"armsight tests"});
  std::map<std::string, ChannelId> channels;
  for (RecordedMessage message; reader.next(message);) {
    if (!channels.contains(message.topic))
      channels[message.topic] = writer.add_channel(message.topic, message.message_type);
    if (message.topic == "/link") {
      wire::LinkRecord record;
      record.ParseFromString(message.data);
      change(record);
      message.data = record.SerializeAsString();
    }
    writer.write(channels[message.topic], message.time, message.data);
  }
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace armsight::replay
