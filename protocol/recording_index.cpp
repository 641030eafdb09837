#include <algorithm>

#include "protocol/recording_format.hpp"

namespace armsight {

using namespace mcap;

namespace {

std::string read_at(std::istream& in, std::uint64_t offset, std::uint64_t size, std::uint64_t file_size) {
  if (offset > file_size || size > file_size - offset) throw RecordingError("an index points beyond the file");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.clear();
  in.seekg(static_cast<std::streamoff>(offset));
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) throw RecordingError("the file cannot be read");
  return bytes;
}

std::uint64_t size_of_file(std::istream& in) {
  in.clear();
  in.seekg(0, std::ios::end);
  const auto end = in.tellg();
  if (end < 0) throw RecordingError("the file cannot be read");
  return static_cast<std::uint64_t>(end);
}

/// Summary section of a closed file, checksum checked.
std::string read_summary_section(std::istream& in) {
  const std::uint64_t file_size = size_of_file(in);
  const std::uint64_t tail = kRecordHead + kFooterBody + kMagic.size();
  if (file_size < tail + kMagic.size() || read_at(in, 0, kMagic.size(), file_size) != kMagic)
    throw RecordingError("no MCAP file: it does not begin with MCAP's magic");
  const std::string end = read_at(in, file_size - tail, tail, file_size);
  Cursor cursor(end);
  if (!end.ends_with(kMagic) || cursor.integer<std::uint8_t>() != kFooter ||
      cursor.integer<std::uint64_t>() != kFooterBody)
    throw RecordingError("the file was not closed: it has no index");
  const auto start = cursor.integer<std::uint64_t>();
  cursor.take(8);
  const auto crc = cursor.integer<std::uint32_t>();
  if (start == 0) throw RecordingError("the file has no index");
  if (start > file_size - tail) throw RecordingError("the footer points beyond the file");
  std::string summary = read_at(in, start, file_size - tail - start, file_size);
  const std::string_view footer_head = std::string_view(end).substr(0, kRecordHead + kFooterBody - 4);
  if (crc != 0 && crc != crc32_of(footer_head, crc32_of(summary)))
    throw RecordingError("the summary's checksum is wrong: the file is damaged");
  return summary;
}

RecordingSummary::Chunk parse_chunk_index(std::string_view body) {
  Cursor cursor(body);
  RecordingSummary::Chunk chunk;
  chunk.start = to_time(cursor.integer<std::uint64_t>());
  chunk.end = to_time(cursor.integer<std::uint64_t>());
  chunk.offset = cursor.integer<std::uint64_t>();
  chunk.length = cursor.integer<std::uint64_t>();
  Cursor offsets(cursor.text());
  while (!offsets.is_at_end()) {
    chunk.channels.push_back(offsets.integer<ChannelId>());
    offsets.take(8);
  }
  return chunk;
}

void parse_statistics(std::string_view body, RecordingSummary& out) {
  Cursor cursor(body);
  out.message_count = cursor.integer<std::uint64_t>();
  cursor.take(2 + 4 + 4 + 4 + 4);
  out.start = to_time(cursor.integer<std::uint64_t>());
  out.end = to_time(cursor.integer<std::uint64_t>());
  Cursor counts(cursor.text());
  while (!counts.is_at_end()) {
    const auto id = counts.integer<ChannelId>();
    const auto count = counts.integer<std::uint64_t>();
    if (const auto channel = out.channels.find(id); channel != out.channels.end()) channel->second.count = count;
  }
}

}  // namespace

RecordingSummary read_summary(std::istream& in) {
  const std::string section = read_summary_section(in);
  RecordingSummary out;
  std::map<std::uint16_t, std::string> schemas;
  Cursor records(section);
  while (!records.is_at_end()) {
    const RecordView record = take_record(records);
    if (record.opcode == kSchema) {
      const SchemaView schema = parse_schema(record.body);
      schemas[schema.id] = schema.name;
    } else if (record.opcode == kChannel) {
      const ChannelView channel = parse_channel(record.body);
      out.channels[channel.id] = {std::string(channel.topic), schemas[channel.schema], 0};
    } else if (record.opcode == kStatistics) {
      parse_statistics(record.body, out);
    } else if (record.opcode == kChunkIndex) {
      out.chunks.push_back(parse_chunk_index(record.body));
    }
  }
  return out;
}

std::vector<RecordedMessage> read_messages(std::istream& in, const RecordingSummary& summary,
                                           const std::vector<std::string>& topics, Time from, Time to) {
  const auto is_wanted = [&](ChannelId id) {
    const auto channel = summary.channels.find(id);
    if (channel == summary.channels.end()) return false;
    return topics.empty() || std::find(topics.begin(), topics.end(), channel->second.topic) != topics.end();
  };
  const std::uint64_t file_size = size_of_file(in);
  std::vector<RecordedMessage> out;
  for (const RecordingSummary::Chunk& chunk : summary.chunks) {
    if (chunk.end < from || chunk.start > to) continue;
    if (std::none_of(chunk.channels.begin(), chunk.channels.end(), is_wanted)) continue;
    const std::string bytes = read_at(in, chunk.offset, chunk.length, file_size);
    Cursor whole(bytes);
    const RecordView record = take_record(whole);
    if (record.opcode != kChunk) throw RecordingError("a chunk index points at something else");
    Cursor records(chunk_records(record.body));
    while (!records.is_at_end()) {
      const RecordView inner = take_record(records);
      if (inner.opcode != kMessage) continue;
      const MessageView view = parse_message(inner.body);
      if (!is_wanted(view.channel) || view.time < from || view.time > to) continue;
      const auto& channel = summary.channels.at(view.channel);
      out.push_back({channel.topic, channel.message_type, view.time, view.sequence, std::string(view.data)});
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return out;
}

}  // namespace armsight
