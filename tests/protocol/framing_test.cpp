// What only this shows: a stream cut anywhere gives the same frames, and a bad header costs no memory.
#include "protocol/framing.hpp"

#include <gtest/gtest.h>

namespace armsight::wire {
namespace {

std::vector<std::string> feed_in_steps(FrameDecoder& decoder, const std::string& bytes, std::size_t step) {
  std::vector<std::string> payloads;
  for (std::size_t at = 0; at < bytes.size(); at += step)
    decoder.feed(std::span(bytes).subspan(at, std::min(step, bytes.size() - at)), payloads);
  return payloads;
}

TEST(Framing, HasTheDocumentedBytes) {
  const std::string payload = "abc";
  EXPECT_EQ(encode_frame(FrameType::kLink, payload), std::string("AS\x01\x01\x03\0\0\0abc", 11));
}

TEST(Framing, GivesTheSamePayloadsHoweverTheStreamIsCut) {
  const std::vector<std::string> sent = {"first", "", std::string(300, 'x'), "last"};
  std::string bytes;
  for (const auto& payload : sent) bytes += encode_frame(FrameType::kLink, payload);
  for (const std::size_t step : {1U, 3U, 7U, 8U, 9U, 100U, 1000U}) {
    FrameDecoder decoder(FrameType::kLink, kMaxToController);
    EXPECT_EQ(feed_in_steps(decoder, bytes, step), sent) << step;
    EXPECT_EQ(decoder.error(), FrameError::kNone);
  }
}

TEST(Framing, TakesThePayloadOfExactlyTheLimitAndNoByteMore) {
  for (const std::size_t size : {kMaxToController, kMaxToController + 1}) {
    FrameDecoder decoder(FrameType::kLink, kMaxToController);
    std::vector<std::string> payloads;
    const bool is_taken = size == kMaxToController;
    EXPECT_EQ(decoder.feed(encode_frame(FrameType::kLink, std::string(size, 'x')), payloads), is_taken);
    EXPECT_EQ(decoder.error(), is_taken ? FrameError::kNone : FrameError::kTooLong);
    EXPECT_EQ(payloads.size(), is_taken ? 1U : 0U);
  }
}

TEST(Framing, RefusesABadHeaderAndStaysInError) {
  struct Case { std::size_t at; char value; FrameError error; };
  for (const Case& c : {Case{0, 'X', FrameError::kBadMagic}, Case{2, 2, FrameError::kBadVersion},
                        Case{3, 2, FrameError::kWrongType}, Case{7, 1, FrameError::kTooLong}}) {
    std::string bytes = encode_frame(FrameType::kLink, std::string("abc"));
    bytes[c.at] = c.value;
    FrameDecoder decoder(FrameType::kLink, kMaxToController);
    std::vector<std::string> payloads;
    EXPECT_FALSE(decoder.feed(bytes, payloads));
    EXPECT_EQ(decoder.error(), c.error) << to_text(decoder.error());
    EXPECT_FALSE(decoder.feed(encode_frame(FrameType::kLink, std::string("good")), payloads));
    EXPECT_TRUE(payloads.empty());
  }
}

TEST(Framing, TellsThePeersMajorVersion) {
  std::string bytes = encode_frame(FrameType::kLink, std::string("abc"));
  bytes[2] = 9;
  FrameDecoder decoder(FrameType::kLink, kMaxToController);
  std::vector<std::string> payloads;
  EXPECT_FALSE(decoder.feed(bytes, payloads));
  EXPECT_EQ(decoder.peer_major(), 9);
}

TEST(Framing, KeepsFramesBeforeTheBadOne) {
  FrameDecoder decoder(FrameType::kLink, kMaxToController);
  std::vector<std::string> payloads;
  EXPECT_FALSE(decoder.feed(encode_frame(FrameType::kLink, std::string("good")) + "garbage!", payloads));
  EXPECT_EQ(payloads, std::vector<std::string>{"good"});
}

}  // namespace
}  // namespace armsight::wire
