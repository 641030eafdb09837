// What closes a recording: schemas, channels, statistics and chunk indexes again, so that a reader need not read it all.
#include <functional>

#include "protocol/recording_format.hpp"
#include "protocol/recording_schemas.hpp"

namespace armsight {

using namespace mcap;

std::string RecordingWriter::schema_body(std::uint16_t id) const {
  std::string body;
  append_le<std::uint16_t>(body, id);
  append_text(body, schemas_[id - 1U]);
  append_text(body, "protobuf");
  append_text(body, recording_descriptor_set());
  return body;
}

std::string RecordingWriter::channel_body(ChannelId id) const {
  const Channel& channel = channels_[id];
  std::string body;
  append_le<std::uint16_t>(body, id);
  append_le<std::uint16_t>(body, channel.schema);
  append_text(body, channel.topic);
  append_text(body, "protobuf");
  append_le<std::uint32_t>(body, 0);  // no metadata
  return body;
}

std::string RecordingWriter::statistics_body() const {
  std::string body;
  append_le<std::uint64_t>(body, message_count_);
  append_le<std::uint16_t>(body, static_cast<std::uint16_t>(schemas_.size()));
  append_le<std::uint32_t>(body, static_cast<std::uint32_t>(channels_.size()));
  append_le<std::uint32_t>(body, 0);  // attachments
  append_le<std::uint32_t>(body, 0);  // metadata
  append_le<std::uint32_t>(body, static_cast<std::uint32_t>(chunks_.size()));
  append_le<std::uint64_t>(body, start_time_);
  append_le<std::uint64_t>(body, end_time_);
  append_le<std::uint32_t>(body, static_cast<std::uint32_t>(10 * channels_.size()));
  for (ChannelId id = 0; id < channels_.size(); ++id) {
    append_le<std::uint16_t>(body, id);
    append_le<std::uint64_t>(body, channels_[id].count);
  }
  return body;
}

std::string RecordingWriter::summary(std::uint64_t start, std::uint64_t& offsets_start) const {
  std::string out, offsets;
  const auto group = [&](Opcode opcode, const std::function<void()>& append_all) {
    const std::size_t begin = out.size();
    append_all();
    if (out.size() == begin) return;
    std::string body;
    append_le<std::uint8_t>(body, opcode);
    append_le<std::uint64_t>(body, start + begin);
    append_le<std::uint64_t>(body, out.size() - begin);
    append_record(offsets, kSummaryOffset, body);
  };
  group(kSchema, [&] {
    for (std::uint16_t id = 1; id <= schemas_.size(); ++id) append_record(out, kSchema, schema_body(id));
  });
  group(kChannel, [&] {
    for (ChannelId id = 0; id < channels_.size(); ++id) append_record(out, kChannel, channel_body(id));
  });
  group(kStatistics, [&] { append_record(out, kStatistics, statistics_body()); });
  group(kChunkIndex, [&] {
    for (const ChunkIndex& chunk : chunks_) {
      std::string body;
      for (const std::uint64_t v : {chunk.start_time, chunk.end_time, chunk.start, chunk.length})
        append_le<std::uint64_t>(body, v);
      append_le<std::uint32_t>(body, static_cast<std::uint32_t>(10 * chunk.index_offsets.size()));
      for (const auto& [id, offset] : chunk.index_offsets) {
        append_le<std::uint16_t>(body, id);
        append_le<std::uint64_t>(body, offset);
      }
      append_le<std::uint64_t>(body, chunk.index_length);
      append_text(body, "");  // compression: none
      append_le<std::uint64_t>(body, chunk.size);
      append_le<std::uint64_t>(body, chunk.size);
      append_record(out, kChunkIndex, body);
    }
  });
  offsets_start = start + out.size();
  return out + offsets;
}

}  // namespace armsight
