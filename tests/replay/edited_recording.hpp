// A recording with messages changed on purpose, to see that it is noticed.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>

#include "protocol/recording.hpp"

namespace armsight::test {

/// A copy in which `edit` had its way with every message.
inline void edit_recording(const std::filesystem::path& from, const std::filesystem::path& to,
                           const std::function<void(RecordedMessage&)>& edit) {
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  RecordingReader reader(in);
  RecordingWriter writer(out, {"armsight tests"});
  std::map<std::string, ChannelId> channels;
  for (RecordedMessage message; reader.next(message);) {
    if (!channels.contains(message.topic))
      channels[message.topic] = writer.add_channel(message.topic, message.message_type);
    edit(message);
    writer.write(channels[message.topic], message.time, message.data);
  }
}

}  // namespace armsight::test
