// Recordings changed on purpose, to see that it is noticed.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "protocol/recording.pb.h"
#include "tests/replay/edited_recording.hpp"

namespace armsight::replay {

/// A copy in which `change` had its way with every message of the link.
inline void copy_recording(const std::filesystem::path& from, const std::filesystem::path& to,
                           const std::function<void(wire::LinkRecord&)>& change) {
  test::edit_recording(from, to, [&](RecordedMessage& message) {
    if (message.topic != "/link") return;
    wire::LinkRecord record;
    record.ParseFromString(message.data);
    change(record);
    message.data = record.SerializeAsString();
  });
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace armsight::replay
