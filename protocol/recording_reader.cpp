#include <algorithm>

#include "protocol/recording_format.hpp"

namespace armsight {

using namespace mcap;

RecordingReader::RecordingReader(std::istream& in) : in_(in) {
  std::string magic;
  if (!read_exactly(kMagic.size(), magic) || magic != kMagic) fail("no MCAP file: it does not begin with MCAP's magic");
  if (!read_record()) fail("cut inside its header");
  if (opcode_ != kHeader) fail("the first record is no header");
}

void RecordingReader::fail(const std::string& rule) const {
  throw RecordingError("byte " + std::to_string(record_offset_) + ": " + rule);
}

/// False where the file ends before. Grows as bytes come, so that a false length costs no memory.
bool RecordingReader::read_exactly(std::size_t size, std::string& bytes) {
  constexpr std::size_t kStep = 1024 * 1024;
  bytes.clear();
  while (bytes.size() < size) {
    const std::size_t before = bytes.size();
    bytes.resize(std::min(size, before + kStep));
    in_.read(bytes.data() + before, static_cast<std::streamsize>(bytes.size() - before));
    const auto got = static_cast<std::size_t>(in_.gcount());
    bytes.resize(before + got);
    if (got == 0) return false;
  }
  section_crc_ = crc32_of(bytes, section_crc_);
  offset_ += size;
  return true;
}

/// The next record into opcode_ and body_; false where a cut file ends.
bool RecordingReader::read_record() {
  record_offset_ = offset_;
  crc_before_record_ = section_crc_;
  std::string head;
  if (!read_exactly(kRecordHead, head)) return false;
  Cursor cursor(head);
  opcode_ = cursor.integer<std::uint8_t>();
  const auto length = cursor.integer<std::uint64_t>();
  if (opcode_ == 0) fail("opcode 0 is no record");
  if (length > kMaxRecord) fail("a record of " + std::to_string(length) + " bytes is too long");
  if (opcode_ != kFooter) return read_exactly(static_cast<std::size_t>(length), body_);
  // The summary's checksum covers the footer up to the checksum itself.
  if (length < kFooterBody) fail("the footer is too short");
  std::string rest;
  if (!read_exactly(kFooterBody - 4, body_)) return false;
  crc_before_record_ = section_crc_;
  if (!read_exactly(static_cast<std::size_t>(length) - (kFooterBody - 4), rest)) return false;
  body_ += rest;
  return true;
}

void RecordingReader::take_definition(std::uint8_t opcode, std::string_view body) {
  if (opcode == kSchema) {
    const SchemaView schema = parse_schema(body);
    schemas_[schema.id] = schema.name;
  } else if (opcode == kChannel) {
    const ChannelView channel = parse_channel(body);
    const auto schema = schemas_.find(channel.schema);
    if (channel.schema != 0 && schema == schemas_.end()) fail("a channel names an unknown schema");
    channels_[channel.id] = {std::string(channel.topic), channel.schema == 0 ? "" : schema->second};
  }
}

void RecordingReader::take_message(std::string_view body, RecordedMessage& message) {
  const MessageView view = parse_message(body);
  const auto channel = channels_.find(view.channel);
  if (channel == channels_.end()) fail("a message of an unknown channel");
  message = {channel->second.topic, channel->second.message_type, view.time, view.sequence, std::string(view.data)};
}

/// The next message of the chunk under way.
bool RecordingReader::next_in_chunk(RecordedMessage& message) {
  while (chunk_at_ < chunk_.size()) {
    Cursor cursor(std::string_view(chunk_).substr(chunk_at_));
    const RecordView record = take_record(cursor);
    chunk_at_ = chunk_.size() - cursor.rest().size();
    if (record.opcode == kMessage) {
      take_message(record.body, message);
      return true;
    }
    take_definition(record.opcode, record.body);
  }
  return false;
}

/// After the data: only the footer's checksum is of interest. False where the file was cut.
bool RecordingReader::check_tail() {
  section_crc_ = 0;
  do {
    if (!read_record()) return false;
  } while (opcode_ != kFooter);
  Cursor footer(body_);
  const auto summary_start = footer.integer<std::uint64_t>();
  footer.take(8);
  const auto crc = footer.integer<std::uint32_t>();
  if (summary_start != 0 && crc != 0 && crc != crc_before_record_)
    fail("the summary's checksum is wrong: the file is damaged");
  std::string magic;
  return read_exactly(kMagic.size(), magic) && magic == kMagic;
}

bool RecordingReader::next(RecordedMessage& message) try {
  while (!is_at_end_) {
    if (next_in_chunk(message)) return true;
    if (!read_record()) break;
    if (opcode_ == kMessage) {
      take_message(body_, message);
      return true;
    }
    if (opcode_ == kChunk) {
      chunk_ = chunk_records(body_);
      chunk_at_ = 0;
    } else if (opcode_ == kDataEnd) {
      const auto crc = Cursor(body_).integer<std::uint32_t>();
      if (crc != 0 && crc != crc_before_record_) fail("the data's checksum is wrong: the file is damaged");
      is_complete_ = check_tail();
      break;
    } else {
      take_definition(opcode_, body_);
    }
  }
  is_at_end_ = true;
  return false;
} catch (const RecordingError& e) {
  is_at_end_ = true;
  if (std::string_view(e.what()).starts_with("byte ")) throw;
  fail(e.what());
}

}  // namespace armsight
