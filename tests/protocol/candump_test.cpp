#include "protocol/candump.hpp"

#include <gtest/gtest.h>

namespace armsight {
namespace {

TEST(Candump, WritesTheDocumentedLine) {
  const CandumpLine line{time_from_ns(1436509052249713999), "can0", {0x044, 5, {0x2A, 0x36, 0x6C, 0x2B, 0xBA}}, false};
  EXPECT_EQ(to_candump(line), "(1436509052.249713) can0 044#2A366C2BBA");
}

TEST(Candump, ReadsWhatItWrites) {
  for (const bool is_error : {false, true}) {
    const CandumpLine line{time_from_ns(12345678000), "emu", {0x7FF, 8, {1, 2, 3, 4, 5, 6, 7, 0xFF}}, is_error};
    const CandumpResult result = parse_candump(to_candump(line) + "\r\n");
    ASSERT_TRUE(result.line) << result.why;
    EXPECT_EQ(result.line->time, line.time);
    EXPECT_EQ(result.line->interface, "emu");
    EXPECT_EQ(result.line->frame, line.frame);
    EXPECT_EQ(result.line->is_error_frame, is_error);
  }
}

TEST(Candump, WritesErrorFramesAsTheKernelFlagsThem) {
  CandumpLine line{time_from_ns(0), "can0", {0x040, 8, {}}, true};  // bus-off
  EXPECT_EQ(to_candump(line), "(0000000000.000000) can0 20000040#0000000000000000");
}

TEST(Candump, WritesTimesBeforeZeroAsZero) {
  EXPECT_EQ(to_candump({time_from_ns(-5), "c", {1, 0, {}}, false}), "(0000000000.000000) c 001#");
}

TEST(Candump, RefusesWithTheReason) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "must begin with a time such as (1436509052.249713)"},
      {"(1.5) can0 123#", "must begin with a time such as (1436509052.249713)"},
      {"(-1.000000) can0 123#", "must begin with a time such as (1436509052.249713)"},
      {"(99999999999999.000000) can0 123#", "must begin with a time such as (1436509052.249713)"},
      {"(1.000000) can0", "the interface must have 1 to 15 characters"},
      {"(1.000000) can0 123", "no '#' between identifier and data"},
      {"(1.000000) can0 00012345#00", "29-bit identifier: this arm uses 11 bits"},
      {"(1.000000) can0 123##1000102030405060708", "CAN FD frame of more than 8 bytes: this arm uses none"},
      {"(1.000000) can0 123##", "a CAN FD frame needs its flags after '##'"},
      {"(1.000000) can0 123#R8", "remote frame: this arm uses none"},
      {"(1.000000) can0 FFF#", "the identifier has more than 11 bits"},
      {"(1.000000) can0 12#", "the identifier must have 3 or 8 hexadecimal digits"},
      {"(1.000000) can0 123#0", "the data must be 0 to 8 bytes of two hexadecimal digits"},
      {"(1.000000) can0 123#-1", "the data must be 0 to 8 bytes of two hexadecimal digits"},
      {"(1.000000) can0 123#112233445566778899", "the data must be 0 to 8 bytes of two hexadecimal digits"}};
  for (const auto& [text, why] : cases) {
    const CandumpResult result = parse_candump(text);
    EXPECT_FALSE(result.line) << text;
    EXPECT_EQ(result.why, why) << text;
  }
}

}  // namespace
}  // namespace armsight
