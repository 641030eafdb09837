// Records of the MCAP container: u8 opcode, u64 length, body; little-endian; texts and maps with a u32 byte length.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/little_endian.hpp"
#include "protocol/recording.hpp"

namespace armsight::mcap {

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t kRecordHead = 9, kFooterBody = 20;
inline constexpr std::uint64_t kMaxRecord = 256ULL * 1024 * 1024;  ///< longer ones are refused

enum Opcode : std::uint8_t {
  kHeader = 0x01, kFooter = 0x02, kSchema = 0x03, kChannel = 0x04, kMessage = 0x05, kChunk = 0x06, kMessageIndex = 0x07,
  kChunkIndex = 0x08, kStatistics = 0x0B, kSummaryOffset = 0x0E, kDataEnd = 0x0F
};

inline std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));  // zlib's own byte type
}

/// "" and texts: u32 length and bytes.
inline void append_text(std::string& body, std::string_view text) {
  append_le<std::uint32_t>(body, static_cast<std::uint32_t>(text.size()));
  body += text;
}

inline void append_record(std::string& out, Opcode opcode, std::string_view body) {
  append_le<std::uint8_t>(out, opcode);
  append_le<std::uint64_t>(out, body.size());
  out += body;
}

/// Reads a record's fields; a body that is too short is a RecordingError.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}
  template <std::integral T>
  T integer() {
    return read_le<T>(take(sizeof(T)).data());
  }
  std::string_view text() { return take(integer<std::uint32_t>()); }
  std::string_view take(std::uint64_t size) {
    if (size > bytes_.size()) throw RecordingError("a record is shorter than its fields");
    const std::string_view out = bytes_.substr(0, static_cast<std::size_t>(size));
    bytes_.remove_prefix(static_cast<std::size_t>(size));
    return out;
  }
  std::string_view rest() const { return bytes_; }
  bool is_at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

struct RecordView {
  std::uint8_t opcode = 0;
  std::string_view body;
};
/// The next record inside a chunk or a summary.
RecordView take_record(Cursor& records);

/// The records of a chunk's body, after its compression, size and checksum were checked.
std::string_view chunk_records(std::string_view chunk_body);

struct MessageView {
  ChannelId channel = 0;
  std::uint32_t sequence = 0;
  Time time;
  std::string_view data;
};
MessageView parse_message(std::string_view body);

struct SchemaView {
  std::uint16_t id = 0;
  std::string_view name;
};
SchemaView parse_schema(std::string_view body);

struct ChannelView {
  ChannelId id = 0;
  std::uint16_t schema = 0;
  std::string_view topic;
};
ChannelView parse_channel(std::string_view body);

/// A time of the file, refused beyond what our clocks hold.
Time to_time(std::uint64_t ns);

}  // namespace armsight::mcap
