// Recordings: MCAP files whose channels are our protobuf messages, schemas inside, so that any MCAP reader shows them.
// Chunked and indexed, with checksums and a summary; a file cut by a crash is readable up to its last whole chunk.
// Times are given, in the recorder's clock. No protobuf in here: payloads are serialized messages.
#pragma once

#include <cstdint>
#include <istream>
#include <map>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "shared/time.hpp"

namespace armsight {

/// A recording that cannot be read; what() names the place in the file and the rule.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using ChannelId = std::uint16_t;

struct RecordingOptions {
  std::string program = "armsight";          ///< stands in the header as the library
  std::size_t chunk_bytes = 256 * 1024;      ///< a chunk ends when it has grown so long
};

class RecordingWriter {
 public:
  /// `out` must outlive the writer. A failing stream shows in is_good().
  explicit RecordingWriter(std::ostream& out, RecordingOptions options = {});
  /// Closes the file.
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// `message_type`: a message of arm_link, recording or camera_stream.proto, e.g. "armsight.wire.TickRecord"; else
  /// std::invalid_argument.
  ChannelId add_channel(const std::string& topic, const std::string& message_type);
  /// A message at a time; times before 0 are filed under 0 (MCAP knows none; the messages carry their own).
  void write(ChannelId channel, Time time, std::string_view serialized_message);
  /// Ends the chunk and flushes the stream: what was written so far survives a crash. Call it every second.
  void flush();
  /// Writes the rest, index and summary. Nothing may be written afterwards.
  void close();
  bool is_good() const { return out_.good(); }
  std::uint64_t message_count() const { return message_count_; }
  std::uint64_t bytes_written() const { return offset_; }

 private:
  struct Channel {
    std::string topic, message_type;
    std::uint16_t schema = 0;
    std::uint32_t sequence = 0;
    std::uint64_t count = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  ///< time, offset in the chunk under way
  };
  struct ChunkIndex {
    std::uint64_t start_time = 0, end_time = 0, start = 0, length = 0, index_length = 0, size = 0;
    std::map<ChannelId, std::uint64_t> index_offsets;
  };

  void put(std::string_view bytes);
  void put_record(std::uint8_t opcode, std::string_view body);
  void end_chunk();
  std::string summary(std::uint64_t start, std::uint64_t& offsets_start) const;
  std::string schema_body(std::uint16_t id) const;
  std::string channel_body(ChannelId id) const;
  std::string statistics_body() const;

  std::ostream& out_;
  RecordingOptions options_;
  std::uint64_t offset_ = 0;
  std::uint32_t data_crc_ = 0;
  std::vector<std::string> schemas_;  ///< names; id = position + 1
  std::vector<Channel> channels_;     ///< id = position
  std::string chunk_;
  std::uint64_t chunk_start_time_ = 0, chunk_end_time_ = 0;
  std::vector<ChunkIndex> chunks_;
  std::uint64_t message_count_ = 0, start_time_ = 0, end_time_ = 0;
  bool is_closed_ = false;
};

struct RecordedMessage {
  std::string topic;
  std::string message_type;
  Time time;
  std::uint32_t sequence = 0;
  std::string data;
};

/// Reads from the start, in the order of the file, without seeking. Checks every checksum it meets.
class RecordingReader {
 public:
  /// Throws RecordingError if this is no MCAP file.
  explicit RecordingReader(std::istream& in);
  /// False at the end, or where a file that was cut ends. Throws RecordingError on a damaged or foreign file.
  bool next(RecordedMessage& message);
  /// After next() answered false: was the file closed properly?
  bool is_complete() const { return is_complete_; }

 private:
  struct Channel {
    std::string topic, message_type;
  };
  bool read_exactly(std::size_t size, std::string& bytes);
  bool read_record();
  bool next_in_chunk(RecordedMessage& message);
  bool check_tail();
  void take_message(std::string_view body, RecordedMessage& message);
  void take_definition(std::uint8_t opcode, std::string_view body);
  [[noreturn]] void fail(const std::string& rule) const;

  std::istream& in_;
  std::uint64_t offset_ = 0, record_offset_ = 0;
  std::uint32_t section_crc_ = 0, crc_before_record_ = 0;  ///< of the section under way
  std::uint8_t opcode_ = 0;
  std::string body_;
  std::string chunk_;
  std::size_t chunk_at_ = 0;
  bool is_complete_ = false, is_at_end_ = false;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<ChannelId, Channel> channels_;
};

struct RecordingSummary {
  struct Channel {
    std::string topic, message_type;
    std::uint64_t count = 0;
  };
  struct Chunk {
    Time start, end;
    std::uint64_t offset = 0, length = 0;
    std::vector<ChannelId> channels;
  };
  std::uint64_t message_count = 0;
  Time start, end;
  std::map<ChannelId, Channel> channels;
  std::vector<Chunk> chunks;
};

/// From the index at the end of the file; throws RecordingError (a cut file has none: use RecordingReader).
RecordingSummary read_summary(std::istream& in);
/// Messages of some topics (empty: all) with from ≤ time ≤ to, in order of time; reads only chunks that can hold any.
std::vector<RecordedMessage> read_messages(std::istream& in, const RecordingSummary& summary,
                                           const std::vector<std::string>& topics, Time from, Time to);

}  // namespace armsight
