// MIT / DAMIAO frames against bytes worked out by hand from controller.md §4.6: 16 and 12 bit codes over ± the range.
#include "protocol/mit_frames.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace armsight {
namespace {

constexpr MitRanges kDm4310{12.5, 30.0, 10.0};

std::string hex(const CanFrame& f) {
  std::string out;
  for (int i = 0; i < f.size; ++i) {
    char text[4];
    std::snprintf(text, sizeof text, "%02X", f.data[static_cast<std::size_t>(i)]);
    out += text;
  }
  return out;
}

CanFrame frame(std::uint32_t id, std::array<std::uint8_t, 8> data) {
  CanFrame f;
  f.id = id;
  f.size = 8;
  f.data = data;
  return f;
}

TEST(MitFrames, CommandsAreTheseBytes) {
  const auto bytes = [](const MitCommand& c) { return hex(encode(c, 1, kDm4310)); };
  EXPECT_EQ(bytes({}), "7FFF7FF0000007FF") << "all at rest: the frame that the drives' own tools send";
  // q: (1 + 12.5) / 25 · 65535 = 35388.9 → 8A3D; speed: (2 + 30) / 60 · 4095 = 2184 → 888; Kp: 80 / 500 · 4095 = 655.2
  // → 28F; Kd: 2 / 5 · 4095 = 1638 → 666; torque: (-3 + 10) / 20 · 4095 = 1433.25 → 599.
  EXPECT_EQ(bytes({1.0, 2.0, 80.0, 2.0, -3.0}), "8A3D88828F666599");
  EXPECT_EQ(bytes({-12.5, -30.0, 0.0, 0.0, -10.0}), "0000000000000000");
  EXPECT_EQ(encode(MitCommand{}, 5, kDm4310).id, 5u);
}

TEST(MitFrames, OrdersAreSevenFFAndOneByte) {
  EXPECT_EQ(hex(encode(MitOrder::kEnable, 1)), "FFFFFFFFFFFFFFFC");
  EXPECT_EQ(hex(encode(MitOrder::kDisable, 1)), "FFFFFFFFFFFFFFFD");
  EXPECT_EQ(hex(encode(MitOrder::kClearFault, 1)), "FFFFFFFFFFFFFFFB");
}

TEST(MitFrames, RegistersAreTheseBytes) {
  EXPECT_EQ(encode_mit_read(MitRegister::kControlMode, 4).id, 0x7FFu);
  EXPECT_EQ(hex(encode_mit_read(MitRegister::kControlMode, 4)), "0400330A00000000");
  EXPECT_EQ(hex(encode_mit_write(MitRegister::kTimeout, 400, 4)), "0400550990010000") << "20 ms in steps of 50 us";
  EXPECT_EQ(hex(encode_mit_refresh(4)), "0400CC0000000000");
  const CanFrame answer = frame(0x14, {4, 0, 0x33, 0x15, 0x00, 0x00, 0x48, 0x41});  // 12.5 as a float
  EXPECT_EQ(decode_mit_answer(answer, 0x14, 4, MitRegister::kPositionRange, false), 0x41480000u);
  EXPECT_FALSE(decode_mit_answer(answer, 0x14, 4, MitRegister::kSpeedRange, false)) << "another register";
  EXPECT_FALSE(decode_mit_answer(answer, 0x14, 4, MitRegister::kPositionRange, true)) << "a read, not a write";
  EXPECT_FALSE(decode_mit_answer(answer, 0x15, 4, MitRegister::kPositionRange, false)) << "another drive";
}

TEST(MitFrames, SamplesAreDecodedByHand) {
  const auto sample = decode_mit_sample(frame(0x11, {0x11, 0x8A, 0x3D, 0x88, 0x85, 0x99, 40, 45}), 0x11, 1, kDm4310);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->state, MitState::kEnabled);
  EXPECT_NEAR(sample->position_rad, 1.0, 25.0 / 65535);
  EXPECT_NEAR(sample->speed_rad_s, 2.0, 60.0 / 4095);
  EXPECT_NEAR(sample->torque_Nm, -3.0, 20.0 / 4095);
  EXPECT_EQ(sample->power_stage_C, 40);
  EXPECT_EQ(sample->winding_C, 45);
  const auto lost = decode_mit_sample(frame(0x11, {0xD1, 0x7F, 0xFF, 0x7F, 0xF7, 0xFF, 0, 0}), 0x11, 1, kDm4310);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->state, MitState::kCommandsLost);
  EXPECT_TRUE(is_mit_fault(lost->state));
  EXPECT_STREQ(to_text(lost->state), "commands lost: its time-out passed");
}

TEST(MitFrames, SamplesOfOthersAreNotTaken) {
  const CanFrame good = frame(0x11, {0x11, 0x80, 0, 0x80, 0x08, 0, 0, 0});
  EXPECT_TRUE(decode_mit_sample(good, 0x11, 1, kDm4310));
  EXPECT_FALSE(decode_mit_sample(good, 0x12, 1, kDm4310)) << "another identifier";
  EXPECT_FALSE(decode_mit_sample(good, 0x11, 2, kDm4310)) << "another motor";
  CanFrame short_one = good;
  short_one.size = 6;
  EXPECT_FALSE(decode_mit_sample(short_one, 0x11, 1, kDm4310));
}

TEST(MitFrames, BeyondTheRangeIsHeldAtItsEnd) {
  const auto bytes = [](const MitCommand& c) { return hex(encode(c, 1, kDm4310)); };
  EXPECT_EQ(bytes({99, 99, 0, 0, 0}), bytes({12.5, 30, 0, 0, 0}));
  EXPECT_EQ(bytes({-99, -99, -5, -5, -99}), "0000000000000000");
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(bytes({nan, inf, nan, nan, -inf}), bytes({})) << "what is no number moves nothing";
}

// A command with everything at its end would read as an order; the worst of them sets the drive's zero.
TEST(MitFrames, NoCommandLooksLikeAnOrder) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0.95, 1.05);
  const auto is_command = [](const CanFrame& f) {
    const auto request = decode_mit_request(f, 1, kDm4310);
    return request && request->kind == MitRequest::Kind::kCommand;
  };
  EXPECT_TRUE(is_command(encode(MitCommand{12.5, 30, 500, 5, 10}, 1, kDm4310)));
  for (int i = 0; i < 20'000; ++i) {
    const MitCommand c{12.5 * any(random), 30 * any(random), 500 * any(random), 5 * any(random), 10 * any(random)};
    ASSERT_TRUE(is_command(encode(c, 1, kDm4310)));
  }
}

TEST(MitFrames, WhatIsEncodedComesBackWithinAStep) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (int i = 0; i < 5'000; ++i) {
    const MitCommand c{12.5 * part(random), 30 * part(random), 250 + 250 * part(random), 2.5 + 2.5 * part(random),
                       10 * part(random)};
    const auto request = decode_mit_request(encode(c, 3, kDm4310), 3, kDm4310);
    ASSERT_TRUE(request);
    EXPECT_NEAR(request->command.position_rad, c.position_rad, 12.5 / 65535 * 1.001);
    EXPECT_NEAR(request->command.speed_rad_s, c.speed_rad_s, 30.0 / 4095 * 1.001);
    EXPECT_NEAR(request->command.kp_Nm_rad, c.kp_Nm_rad, 250.0 / 4095 * 1.001);
    EXPECT_NEAR(request->command.kd_Nms_rad, c.kd_Nms_rad, 2.5 / 4095 * 1.001);
    EXPECT_NEAR(request->command.torque_Nm, c.torque_Nm, 10.0 / 4095 * 1.001);
    const MitSample s{MitState::kEnabled, c.position_rad, c.speed_rad_s, c.torque_Nm, 30, 40};
    const auto sample = decode_mit_sample(encode(s, 0x13, 3, kDm4310), 0x13, 3, kDm4310);
    ASSERT_TRUE(sample);
    EXPECT_NEAR(sample->position_rad, s.position_rad, 12.5 / 65535 * 1.001);
  }
}

TEST(MitFrames, AnythingIsDecodedOrRefused) {
  std::mt19937 random(3);
  for (int i = 0; i < 50'000; ++i) {
    CanFrame f;
    f.id = i % 3 == 0 ? 1 : i % 3 == 1 ? 0x11 : kMitRegisterId;
    f.size = static_cast<std::uint8_t>(random() % 9);
    for (std::uint8_t& byte : f.data) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? 0xFF : random());
    const auto sample = decode_mit_sample(f, 0x11, 1, kDm4310);
    const auto request = decode_mit_request(f, 1, kDm4310);
    ASSERT_LE(sample ? std::abs(sample->position_rad) : 0.0, 12.5);
    ASSERT_LE(request ? std::abs(request->command.torque_Nm) : 0.0, 10.0);
    (void)decode_mit_answer(f, 0x11, 1, MitRegister::kControlMode, i % 2 == 0);
  }
}

}  // namespace
}  // namespace armsight
