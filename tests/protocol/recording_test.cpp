#include "protocol/recording.hpp"

#include <gtest/gtest.h>

#include "sample_recording.hpp"

namespace armsight {
namespace {

/// All messages by streaming; `is_complete` as the reader says at the end.
std::vector<RecordedMessage> stream_all(const std::string& bytes, bool& is_complete) {
  std::istringstream in(bytes);
  RecordingReader reader(in);
  std::vector<RecordedMessage> out;
  for (RecordedMessage message; reader.next(message);) out.push_back(message);
  is_complete = reader.is_complete();
  return out;
}

std::string failure_of(const std::string& bytes) {
  try {
    bool is_complete = false;
    stream_all(bytes, is_complete);
    return is_complete ? "complete" : "cut";
  } catch (const RecordingError& e) {
    return e.what();
  }
}

TEST(Recording, StreamsBackWhatWasWritten) {
  bool is_complete = false;
  const auto messages = stream_all(sample_recording(), is_complete);
  EXPECT_TRUE(is_complete);
  ASSERT_EQ(messages.size(), 505U);
  int tick = 0;
  for (const RecordedMessage& m : messages) {
    if (m.topic != "/tick") continue;
    EXPECT_EQ(m.message_type, "armsight.wire.TickRecord");
    EXPECT_EQ(to_ns(m.time), kSampleStart_ns + tick * kSamplePeriod_ns);
    wire::TickRecord record;
    ASSERT_TRUE(record.ParseFromString(m.data));
    EXPECT_EQ(record.q_reading_rad(0), 0.001 * tick);
    EXPECT_EQ(m.sequence, static_cast<std::uint32_t>(tick++));
  }
  EXPECT_EQ(tick, kSampleTicks);
}

TEST(Recording, AnswersByTopicAndTimeFromTheIndex) {
  std::istringstream in(sample_recording());
  const RecordingSummary summary = read_summary(in);
  EXPECT_EQ(summary.message_count, 505U);
  EXPECT_EQ(to_ns(summary.start), kSampleStart_ns);
  EXPECT_EQ(to_ns(summary.end), kSampleStart_ns + 499 * kSamplePeriod_ns);
  EXPECT_GT(summary.chunks.size(), 5U);
  ASSERT_EQ(summary.channels.size(), 2U);
  EXPECT_EQ(summary.channels.at(1).topic, "/link");
  EXPECT_EQ(summary.channels.at(1).count, 5U);

  const auto from = time_from_ns(kSampleStart_ns + 100 * kSamplePeriod_ns);
  const auto to = time_from_ns(kSampleStart_ns + 200 * kSamplePeriod_ns);
  EXPECT_EQ(read_messages(in, summary, {}, from, to).size(), 103U);
  const auto links = read_messages(in, summary, {"/link"}, from, to);
  ASSERT_EQ(links.size(), 2U);
  wire::LinkRecord record;
  ASSERT_TRUE(record.ParseFromString(links[1].data));
  EXPECT_EQ(record.envelope().sequence(), 200U);
  EXPECT_TRUE(read_messages(in, summary, {"/nothing"}, from, to).empty());
}

TEST(Recording, IsReadUpToItsLastWholeChunkWhereverItIsCut) {
  const std::string whole = sample_recording();
  std::size_t before = 0;
  for (std::size_t size = 8; size < whole.size(); size += 997) {
    bool is_complete = true;
    std::size_t count = 0;
    try {
      count = stream_all(whole.substr(0, size), is_complete).size();
    } catch (const RecordingError& e) {
      EXPECT_LT(size, 60U) << e.what();  // not even a header
      continue;
    }
    EXPECT_FALSE(is_complete) << size;
    EXPECT_GE(count, before);
    before = count;
  }
  EXPECT_EQ(before, 505U);
}

TEST(Recording, KeepsWhatWasFlushedWhenTheProgramDies) {
  std::ostringstream out;
  RecordingWriter writer(out);
  write_sample(writer);
  writer.flush();
  bool is_complete = true;
  EXPECT_EQ(stream_all(out.str(), is_complete).size(), 505U);
  EXPECT_FALSE(is_complete);
}

TEST(Recording, RefusesEveryFlippedBitItCanMeet) {
  const std::string whole = sample_recording();
  int refused = 0, tried = 0;
  for (std::size_t at = 0; at < whole.size(); at += 61) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    ++tried;
    refused += failure_of(damaged) != "complete";
  }
  EXPECT_EQ(refused, tried);
}

TEST(Recording, RefusesADamagedSummary) {
  std::string bytes = sample_recording();
  bytes[bytes.size() - 100] ^= 1;
  std::istringstream in(bytes);
  EXPECT_THROW(read_summary(in), RecordingError);
}

TEST(Recording, SaysThatAFileWasNotClosed) {
  const std::string bytes = sample_recording();
  std::istringstream in(bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(read_summary(in), RecordingError);
  EXPECT_EQ(failure_of("not a recording, but text long enough to be one"),
            "byte 0: no MCAP file: it does not begin with MCAP's magic");
}

TEST(Recording, RefusesUnknownMessageTypes) {
  std::ostringstream out;
  RecordingWriter writer(out);
  EXPECT_THROW(writer.add_channel("/x", "armsight.wire.Nothing"), std::invalid_argument);
  EXPECT_EQ(writer.add_channel("/model", "armsight.wire.ModelUpdate"), 0);
  EXPECT_EQ(writer.add_channel("/camera", "armsight.wire.Frame"), 1);
}

TEST(Recording, FilesTimesBeforeZeroUnderZero) {
  std::ostringstream out;
  RecordingWriter writer(out);
  writer.write(writer.add_channel("/can", "armsight.wire.CanRecord"), time_from_ns(-7), "");
  writer.close();
  bool is_complete = false;
  const auto messages = stream_all(out.str(), is_complete);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(to_ns(messages[0].time), 0);
}

TEST(Recording, IsTheSameByteForByteForTheSameInput) { EXPECT_EQ(sample_recording(), sample_recording()); }

TEST(Recording, OfNothingIsStillAValidFile) {
  std::ostringstream out;
  RecordingWriter(out).close();
  EXPECT_EQ(failure_of(out.str()), "complete");
  std::istringstream in(out.str());
  EXPECT_EQ(read_summary(in).message_count, 0U);
}

}  // namespace
}  // namespace armsight
