// The simulated nodes' SDO server, byte by byte, and the order in which they let PDOs be changed (controller.md §4.2,
// 3).
#include <gtest/gtest.h>

#include "tests/sim/drive_bench.hpp"

namespace armsight::sim {
namespace {

using Bytes = std::array<std::uint8_t, 8>;

CanFrame request(const Bytes& bytes) { return {0x603, 8, bytes}; }

struct Sdo : ::testing::Test {
  test::DriveBench bench;
  Bytes answer(const Bytes& bytes) {
    const CanFrame frame = bench.ask(request(bytes));
    EXPECT_EQ(frame.id, 0x583u);
    return frame.data;
  }
};

TEST_F(Sdo, BootsUpIntoPreOperational) {
  ASSERT_EQ(bench.sent.size(), 1u);
  EXPECT_EQ(bench.sent[0], (CanFrame{0x703, 1, {0x00}}));
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kPreOperational);
}

TEST_F(Sdo, ReadsWithTheSizeInTheCommandByte) {
  EXPECT_EQ(answer({0x40, 0x00, 0x10, 0x00}), (Bytes{0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(answer({0x40, 0x5A, 0x60, 0x00}), (Bytes{0x4B, 0x5A, 0x60, 0x00, 0x02}));
  EXPECT_EQ(answer({0x40, 0x60, 0x60, 0x00}), (Bytes{0x4F, 0x60, 0x60, 0x00, 0x00}));
  EXPECT_EQ(answer({0x40, 0x02, 0x65, 0x00}), (Bytes{0x43, 0x02, 0x65, 0x00, 0x80}));
}

TEST_F(Sdo, WritesAndConfirms) {
  EXPECT_EQ(answer({0x2B, 0x5A, 0x60, 0x00, 0x06}), (Bytes{0x60, 0x5A, 0x60, 0x00}));
  EXPECT_EQ(answer({0x40, 0x5A, 0x60, 0x00}), (Bytes{0x4B, 0x5A, 0x60, 0x00, 0x06}));
}

TEST_F(Sdo, AbortsWithTheCodeThatFits) {
  EXPECT_EQ(answer({0x40, 0x34, 0x12, 0x00}), (Bytes{0x80, 0x34, 0x12, 0x00, 0x00, 0x00, 0x02, 0x06}));  // no object
  EXPECT_EQ(answer({0x40, 0x18, 0x10, 0x09}), (Bytes{0x80, 0x18, 0x10, 0x09, 0x11, 0x00, 0x09, 0x06}));  // no sub
  EXPECT_EQ(answer({0x23, 0x00, 0x10, 0x00}), (Bytes{0x80, 0x00, 0x10, 0x00, 0x02, 0x00, 0x01, 0x06}));  // read-only
  EXPECT_EQ(answer({0x23, 0x5A, 0x60, 0x00}), (Bytes{0x80, 0x5A, 0x60, 0x00, 0x12, 0x00, 0x07, 0x06}));  // too long
  EXPECT_EQ(answer({0x2F, 0x5A, 0x60, 0x00}), (Bytes{0x80, 0x5A, 0x60, 0x00, 0x13, 0x00, 0x07, 0x06}));  // too short
  EXPECT_EQ(answer({0x2B, 0x5A, 0x60, 0x00, 0x09}), (Bytes{0x80, 0x5A, 0x60, 0x00, 0x30, 0x00, 0x09, 0x06}));
  EXPECT_EQ(answer({0x2F, 0x60, 0x60, 0x00, 0x01}), (Bytes{0x80, 0x60, 0x60, 0x00, 0x30, 0x00, 0x09, 0x06}));
  EXPECT_EQ(answer({0x60, 0x00, 0x10, 0x00}), (Bytes{0x80, 0x00, 0x10, 0x00, 0x01, 0x00, 0x04, 0x05}));  // command
}

TEST_F(Sdo, LetsAPdoBeChangedOnlyInvalidAndWithCountZero) {
  bench.configure();
  EXPECT_EQ(bench.read(0x1600, 0), 3u);
  EXPECT_EQ(bench.write(0x1600, 0, 0, 1), kBadState) << "still valid";
  EXPECT_EQ(bench.write(0x1400, 1, 0x204, 4), kBadState) << "moves while valid";
  EXPECT_EQ(bench.write(0x1400, 1, 0x80000203, 4), 0u);
  EXPECT_EQ(bench.write(0x1600, 1, 0x607A0020, 4), kUnsupportedAccess) << "count is not 0";
  EXPECT_EQ(bench.write(0x1600, 0, 0, 1), 0u);
  EXPECT_EQ(bench.write(0x1600, 1, 0x60640020, 4), kCannotMap) << "position actual cannot be received";
  EXPECT_EQ(bench.write(0x1600, 1, 0x607A0010, 4), kCannotMap) << "wrong length";
  EXPECT_EQ(bench.write(0x1600, 1, 0x607A0020, 4), 0u);
  EXPECT_EQ(bench.write(0x1600, 2, 0x607A0020, 4), 0u);
  EXPECT_EQ(bench.write(0x1600, 3, 0x60400010, 4), 0u);
  EXPECT_EQ(bench.write(0x1600, 0, 3, 1), kMappingTooLong) << "80 bits";
  EXPECT_EQ(bench.write(0x1600, 0, 2, 1), 0u);
}

TEST_F(Sdo, IsSilentWhenStoppedAndForOtherNodes) {
  bench.send(encode(Nmt{NmtCommand::kStop, 0}));
  EXPECT_EQ(bench.ask(encode(SdoRead{{0x1000, 0}}, 3)), CanFrame{});
  bench.send(encode(Nmt{NmtCommand::kPreOperational, 3}));
  EXPECT_EQ(bench.ask(encode(SdoRead{{0x1000, 0}}, 4)), CanFrame{});
  EXPECT_EQ(bench.read(0x1018, 4), 3u);
}

}  // namespace
}  // namespace armsight::sim
