// SDO transfers byte by byte as CiA 301 describes them (controller.md §4.2): expedited, in segments, and all the ways
// in which one can end.
#include <gtest/gtest.h>

#include <cstring>

#include "arm_controller/sdo_client.hpp"

namespace armsight::arm::test {
namespace {

using Bytes = std::array<std::uint8_t, 8>;
using namespace std::chrono_literals;

struct SdoTransfer : ::testing::Test {
  SdoClient client;
  Time now = time_from_ns(1'000'000'000);

  Bytes request() {
    const auto frame = client.request_to_send(3, now);
    EXPECT_TRUE(frame);
    if (!frame) return {};
    EXPECT_EQ(frame->id, 0x603u);
    EXPECT_EQ(frame->size, 8);
    return frame->data;
  }
  void answer(const Bytes& bytes) { client.receive({0x583, 8, bytes}, 3); }
  bool is_quiet() { return !client.request_to_send(3, now); }
  std::string text() const { return {client.bytes().begin(), client.bytes().end()}; }
  void write(const char* text) {
    client.start_write({0x2001, 0}, std::span(reinterpret_cast<const std::uint8_t*>(text), std::strlen(text)));
  }
};

TEST_F(SdoTransfer, ReadsExpedited) {
  client.start_read({0x6041, 0});
  EXPECT_EQ(request(), (Bytes{0x40, 0x41, 0x60, 0x00}));
  EXPECT_TRUE(is_quiet());
  answer({0x4B, 0x41, 0x60, 0x00, 0x37, 0x12});
  EXPECT_EQ(client.result(), SdoResult::kDone);
  EXPECT_EQ(client.value(), 0x1237u);
}

TEST_F(SdoTransfer, WritesExpedited) {
  client.start_write({0x605A, 0}, 6, 2);
  EXPECT_EQ(request(), (Bytes{0x2B, 0x5A, 0x60, 0x00, 0x06, 0x00}));
  answer({0x60, 0x5A, 0x60, 0x01});
  EXPECT_EQ(client.result(), SdoResult::kPending) << "another object's answer";
  answer({0x60, 0x5A, 0x60, 0x00});
  EXPECT_EQ(client.result(), SdoResult::kDone);
}

TEST_F(SdoTransfer, ReadsATextInSegmentsWithTheToggleBit) {
  client.start_read({0x1008, 0});
  EXPECT_EQ(request(), (Bytes{0x40, 0x08, 0x10, 0x00}));
  answer({0x41, 0x08, 0x10, 0x00, 16, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x60}));
  answer({0x00, 'd', 'r', 'i', 'v', 'e', ' ', 'n'});
  EXPECT_EQ(request(), (Bytes{0x70}));
  answer({0x10, 'u', 'm', 'b', 'e', 'r', ' ', '1'});
  EXPECT_EQ(request(), (Bytes{0x60}));
  answer({0x0B, '2', '3'});  // toggle 0, five bytes unused, last
  EXPECT_EQ(client.result(), SdoResult::kDone);
  EXPECT_EQ(text(), "drive number 123");
}

TEST_F(SdoTransfer, WritesATextInSegments) {
  write("left elbow");
  EXPECT_EQ(request(), (Bytes{0x21, 0x01, 0x20, 0x00, 10, 0, 0, 0}));
  answer({0x60, 0x01, 0x20, 0x00});
  EXPECT_EQ(request(), (Bytes{0x00, 'l', 'e', 'f', 't', ' ', 'e', 'l'}));
  answer({0x20});
  EXPECT_EQ(request(), (Bytes{0x19, 'b', 'o', 'w'}));  // toggle 1, four bytes unused, last
  answer({0x30});
  EXPECT_EQ(client.result(), SdoResult::kDone);
}

TEST_F(SdoTransfer, ReportsTheServersAbortWithItsCode) {
  client.start_read({0x1234, 0});
  request();
  answer({0x80, 0x34, 0x12, 0x00, 0x00, 0x00, 0x02, 0x06});
  EXPECT_EQ(client.result(), SdoResult::kAborted);
  EXPECT_EQ(client.value(), 0x06020000u);
}

TEST_F(SdoTransfer, AsksThreeTimesAndThenGivesUp) {
  client.start_read({0x1000, 0});
  for (int i = 0; i < SdoClient::kAttempts; ++i) {
    EXPECT_EQ(request()[0], 0x40);
    now += 99ms;
    EXPECT_TRUE(is_quiet());
    now += 1ms;
  }
  EXPECT_TRUE(is_quiet());
  EXPECT_EQ(client.result(), SdoResult::kTimedOut);
}

TEST_F(SdoTransfer, AbortsAndBeginsAgainWhereASegmentDoesNotCome) {
  client.start_read({0x1008, 0});
  request();
  answer({0x41, 0x08, 0x10, 0x00, 9, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x60}));
  now += 100ms;
  EXPECT_EQ(request(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05})) << "time-out";
  EXPECT_EQ(request(), (Bytes{0x40, 0x08, 0x10, 0x00})) << "from the beginning";
}

TEST_F(SdoTransfer, AbortsAWrongToggleAndGivesUpAfterTheThirdAttempt) {
  client.start_read({0x1008, 0});
  for (int i = 0; i < SdoClient::kAttempts; ++i) {
    EXPECT_EQ(request()[0], 0x40);
    answer({0x41, 0x08, 0x10, 0x00, 9, 0, 0, 0});
    request();
    answer({0x10, 'x', 'x', 'x', 'x', 'x', 'x', 'x'});
    EXPECT_EQ(request(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x03, 0x05}));
  }
  EXPECT_EQ(client.result(), SdoResult::kAborted);
  EXPECT_EQ(client.value(), 0x05030000u);
}

TEST_F(SdoTransfer, AbortsWhatIsLongerThanThereIsRoomAndWhatIsShorterThanAnnounced) {
  client.start_read({0x1008, 0});
  request();
  answer({0x41, 0x08, 0x10, 0x00, 65, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x05, 0x00, 0x04, 0x05}));
  EXPECT_EQ(client.result(), SdoResult::kAborted);
  client.start_read({0x1008, 0});
  request();
  answer({0x41, 0x08, 0x10, 0x00, 9, 0, 0, 0});
  request();
  answer({0x01, 'x', 'x', 'x', 'x', 'x', 'x', 'x'});
  EXPECT_EQ(request(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x10, 0x00, 0x07, 0x06})) << "7 of 9 bytes";
}

TEST_F(SdoTransfer, EveryAbortCodeOfTheSpecificationHasItsText) {
  for (const std::uint32_t code :
       {0x05030000u, 0x05040000u, 0x05040001u, 0x05040005u, 0x06010000u, 0x06010001u, 0x06010002u,
        0x06020000u, 0x06040041u, 0x06040042u, 0x06040043u, 0x06040047u, 0x06060000u, 0x06070010u,
        0x06070012u, 0x06070013u, 0x06090011u, 0x06090030u, 0x06090031u, 0x06090032u, 0x06090036u,
        0x060A0023u, 0x08000000u, 0x08000020u, 0x08000021u, 0x08000022u, 0x08000023u, 0x08000024u})
    EXPECT_STRNE(sdo_abort_text(code), sdo_abort_text(0xDEADBEEF)) << std::hex << code;
}

}  // namespace
}  // namespace armsight::arm::test
