#include <algorithm>

#include "protocol/recording_format.hpp"
#include "protocol/recording_schemas.hpp"

namespace armsight {

using namespace mcap;

namespace {

std::uint64_t file_time(Time time) { return static_cast<std::uint64_t>(std::max<std::int64_t>(to_ns(time), 0)); }

}  // namespace

RecordingWriter::RecordingWriter(std::ostream& out, RecordingOptions options) : out_(out), options_(std::move(options)) {
  put(kMagic);
  std::string header;
  append_text(header, "");  // profile: none of the well-known ones
  append_text(header, options_.program);
  put_record(kHeader, header);
}

RecordingWriter::~RecordingWriter() { close(); }

void RecordingWriter::put(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  data_crc_ = crc32_of(bytes, data_crc_);
  offset_ += bytes.size();
}

void RecordingWriter::put_record(std::uint8_t opcode, std::string_view body) {
  std::string head;
  append_le<std::uint8_t>(head, opcode);
  append_le<std::uint64_t>(head, body.size());
  put(head);
  put(body);
}

ChannelId RecordingWriter::add_channel(const std::string& topic, const std::string& message_type) {
  const auto types = recording_message_types();
  if (std::find(types.begin(), types.end(), message_type) == types.end())
    throw std::invalid_argument("recording: no schema for " + message_type);
  auto schema = std::find(schemas_.begin(), schemas_.end(), message_type);
  const auto schema_id = static_cast<std::uint16_t>(schema - schemas_.begin() + 1);
  if (schema == schemas_.end()) {
    schemas_.push_back(message_type);
    put_record(kSchema, schema_body(schema_id));
  }
  const auto id = static_cast<ChannelId>(channels_.size());
  channels_.push_back({topic, message_type, schema_id, 0, 0, {}});
  put_record(kChannel, channel_body(id));
  return id;
}

void RecordingWriter::write(ChannelId id, Time time, std::string_view serialized_message) {
  if (is_closed_) return;
  Channel& channel = channels_.at(id);
  const std::uint64_t ns = file_time(time);
  if (chunk_.empty()) chunk_start_time_ = chunk_end_time_ = ns;
  chunk_start_time_ = std::min(chunk_start_time_, ns);
  chunk_end_time_ = std::max(chunk_end_time_, ns);
  channel.index.emplace_back(ns, chunk_.size());

  append_le<std::uint8_t>(chunk_, kMessage);
  append_le<std::uint64_t>(chunk_, 22 + serialized_message.size());
  append_le<std::uint16_t>(chunk_, id);
  append_le<std::uint32_t>(chunk_, channel.sequence++);
  append_le<std::uint64_t>(chunk_, ns);  // log time
  append_le<std::uint64_t>(chunk_, ns);  // publish time
  chunk_ += serialized_message;

  start_time_ = message_count_ == 0 ? ns : std::min(start_time_, ns);
  end_time_ = std::max(end_time_, ns);
  ++channel.count;
  ++message_count_;
  if (chunk_.size() >= options_.chunk_bytes) end_chunk();
}

void RecordingWriter::end_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{chunk_start_time_, chunk_end_time_, offset_, 0, 0, chunk_.size(), {}};
  std::string body;
  body.reserve(chunk_.size() + 40);
  append_le<std::uint64_t>(body, chunk_start_time_);
  append_le<std::uint64_t>(body, chunk_end_time_);
  append_le<std::uint64_t>(body, chunk_.size());
  append_le<std::uint32_t>(body, crc32_of(chunk_));
  append_text(body, "");
  append_le<std::uint64_t>(body, chunk_.size());
  body += chunk_;
  put_record(kChunk, body);
  index.length = offset_ - index.start;

  for (ChannelId id = 0; id < channels_.size(); ++id) {
    auto& entries = channels_[id].index;
    if (entries.empty()) continue;
    index.index_offsets[id] = offset_;
    std::stable_sort(entries.begin(), entries.end());
    std::string message_index;
    append_le<std::uint16_t>(message_index, id);
    append_le<std::uint32_t>(message_index, static_cast<std::uint32_t>(16 * entries.size()));
    for (const auto& [time, offset] : entries) {
      append_le<std::uint64_t>(message_index, time);
      append_le<std::uint64_t>(message_index, offset);
    }
    put_record(kMessageIndex, message_index);
    entries.clear();
  }
  index.index_length = offset_ - index.start - index.length;
  chunks_.push_back(std::move(index));
  chunk_.clear();
}

void RecordingWriter::flush() {
  end_chunk();
  out_.flush();
}

void RecordingWriter::close() {
  if (is_closed_) return;
  end_chunk();
  std::string data_end;
  append_le<std::uint32_t>(data_end, data_crc_);
  put_record(kDataEnd, data_end);

  const std::uint64_t summary_start = offset_;
  std::uint64_t offsets_start = 0;
  std::string tail = summary(summary_start, offsets_start);
  append_le<std::uint8_t>(tail, kFooter);
  append_le<std::uint64_t>(tail, kFooterBody);
  append_le<std::uint64_t>(tail, summary_start);
  append_le<std::uint64_t>(tail, offsets_start);
  append_le<std::uint32_t>(tail, crc32_of(tail));
  put(tail);
  put(kMagic);
  out_.flush();
  is_closed_ = true;
}

}  // namespace armsight
