#include "protocol/recording_format.hpp"

#include <limits>

namespace armsight::mcap {

RecordView take_record(Cursor& records) {
  RecordView out;
  out.opcode = records.integer<std::uint8_t>();
  out.body = records.take(records.integer<std::uint64_t>());
  return out;
}

std::string_view chunk_records(std::string_view chunk_body) {
  Cursor cursor(chunk_body);
  cursor.take(16);  // first and last time
  const auto size = cursor.integer<std::uint64_t>();
  const auto crc = cursor.integer<std::uint32_t>();
  const std::string_view compression = cursor.text();
  if (!compression.empty())
    throw RecordingError("a chunk is compressed with " + std::string(compression.substr(0, 16)) +
                         "; only uncompressed recordings are read");
  const std::string_view records = cursor.take(cursor.integer<std::uint64_t>());
  if (records.size() != size) throw RecordingError("a chunk's size differs from the size it states");
  if (crc != 0 && crc != crc32_of(records)) throw RecordingError("a chunk's checksum is wrong: the file is damaged");
  return records;
}

Time to_time(std::uint64_t ns) {
  if (ns > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    throw RecordingError("a time is beyond the year 2262");
  return time_from_ns(static_cast<std::int64_t>(ns));
}

MessageView parse_message(std::string_view body) {
  Cursor cursor(body);
  MessageView out;
  out.channel = cursor.integer<ChannelId>();
  out.sequence = cursor.integer<std::uint32_t>();
  out.time = to_time(cursor.integer<std::uint64_t>());
  cursor.take(8);  // publish time
  out.data = cursor.rest();
  return out;
}

SchemaView parse_schema(std::string_view body) {
  Cursor cursor(body);
  SchemaView out;
  out.id = cursor.integer<std::uint16_t>();
  if (out.id == 0) throw RecordingError("schema id 0 is reserved");
  out.name = cursor.text();
  return out;
}

ChannelView parse_channel(std::string_view body) {
  Cursor cursor(body);
  ChannelView out;
  out.id = cursor.integer<ChannelId>();
  out.schema = cursor.integer<std::uint16_t>();
  out.topic = cursor.text();
  return out;
}

}  // namespace armsight::mcap
