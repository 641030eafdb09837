// One literal frame for each row of the CAN tables in protocol/README.md, in candump's notation.
#include "protocol/can_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/candump.hpp"

namespace armsight {
namespace {

std::string text(const CanFrame& f) {
  const std::string line = to_candump({time_from_ns(0), "c", f, false});
  return line.substr(line.rfind(' ') + 1);
}

CanFrame frame(const std::string& text) {
  const CandumpResult result = parse_candump("(0.000000) c " + text);
  EXPECT_TRUE(result.line) << text << ": " << result.why;
  return result.line ? result.line->frame : CanFrame{};
}

TEST(CanFrames, NmtCommand) {
  EXPECT_EQ(text(encode(Nmt{NmtCommand::kStart, 3})), "000#0103");
  EXPECT_EQ(text(encode(Nmt{NmtCommand::kPreOperational, 0})), "000#8000");
  const auto decoded = decode_nmt(frame("000#8105"));
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->command, NmtCommand::kResetNode);
  EXPECT_EQ(decoded->node, 5);
  EXPECT_FALSE(decode_nmt(frame("000#0303")));  // no such command
}

TEST(CanFrames, SyncWithAndWithoutCounter) {
  EXPECT_EQ(text(encode(Sync{10})), "080#0A");
  EXPECT_EQ(text(encode(Sync{0})), "080#");
  EXPECT_EQ(decode_sync(frame("080#07"))->counter, 7);
  EXPECT_EQ(decode_sync(frame("080#"))->counter, 0);
}

TEST(CanFrames, Emergency) {
  EXPECT_EQ(text(encode(Emcy{0x8611, 0x20}, 2)), "082#1186200000000000");
  const auto decoded = decode_emcy(frame("082#1023040000000000"), 2);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->code, 0x2310);
  EXPECT_EQ(decoded->error_register, 4);
}

TEST(CanFrames, Heartbeat) {
  EXPECT_EQ(text(encode(Heartbeat{NmtState::kPreOperational}, 127)), "77F#7F");
  EXPECT_EQ(text(encode(Heartbeat{NmtState::kBootUp}, 1)), "701#00");
  EXPECT_EQ(decode_heartbeat(frame("704#05"), 4)->state, NmtState::kOperational);
  EXPECT_EQ(decode_heartbeat(frame("704#04"), 4)->state, NmtState::kStopped);
  EXPECT_FALSE(decode_heartbeat(frame("704#06"), 4));
}

TEST(CanFrames, Tpdo1) {
  EXPECT_EQ(text(encode(Tpdo1{0x1237, -2, -300}, 5)), "185#3712FEFFFFFFD4FE");
  const auto good = decode_tpdo1(frame("185#3712785634120180"), 5);
  ASSERT_TRUE(good);
  EXPECT_EQ(good->statusword, 0x1237);
  EXPECT_EQ(good->position_counts, 0x12345678);
  EXPECT_EQ(good->torque, -32767);
}

TEST(CanFrames, Rpdo1) {
  EXPECT_EQ(text(encode(Rpdo1{0x000F, -100000, 7}, 1)), "201#0F006079FEFF0700");
  const auto decoded = decode_rpdo1(frame("201#0F006079FEFF0700"), 1);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->controlword, 0x0F);
  EXPECT_EQ(decoded->target_counts, -100000);
  EXPECT_EQ(decoded->torque_offset, 7);
}

TEST(CanFrames, SdoRead) {
  EXPECT_EQ(text(encode(SdoRead{{0x6041, 0}}, 3)), "603#4041600000000000");
  EXPECT_EQ(decode_sdo_read(frame("603#4018100200000000"), 3)->object, (ObjectAddress{0x1018, 2}));
}

// npm's canopen answers four bytes so, and CiA 301 allows it.
TEST(CanFrames, SdoReadAnswerWithoutItsSize) {
  const auto answer = decode_sdo_read_answer({0x583, 8, {0x42, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}}, 3);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->object, (ObjectAddress{0x1000, 0}));
  EXPECT_EQ(answer->value, 0x00020192U);
}

TEST(CanFrames, SdoReadAnswerOfOneToFourBytes) {
  EXPECT_EQ(text(encode(SdoReadAnswer{{0x1001, 0}, 0xAB, 1}, 3)), "583#4F011000AB000000");
  EXPECT_EQ(text(encode(SdoReadAnswer{{0x6041, 0}, 0x1237, 2}, 3)), "583#4B41600037120000");
  EXPECT_EQ(text(encode(SdoReadAnswer{{0x6041, 0}, 0x123456, 3}, 3)), "583#4741600056341200");
  EXPECT_EQ(text(encode(SdoReadAnswer{{0x1000, 0}, 0x00020192, 4}, 3)), "583#4300100092010200");
  const auto decoded = decode_sdo_read_answer(frame("583#4B41600037120000"), 3);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->value, 0x1237U);
  EXPECT_EQ(decoded->size, 2);
  EXPECT_FALSE(decode_sdo_read_answer(frame("583#4108100010000000"), 3));  // segmented: begins elsewhere
}

TEST(CanFrames, SdoWriteOfOneToFourBytes) {
  EXPECT_EQ(text(encode(SdoWrite{{0x6060, 0}, 8, 1}, 3)), "603#2F60600008000000");
  EXPECT_EQ(text(encode(SdoWrite{{0x1017, 0}, 100, 2}, 3)), "603#2B17100064000000");
  EXPECT_EQ(text(encode(SdoWrite{{0x6060, 0}, 0x010203, 3}, 3)), "603#2760600003020100");
  EXPECT_EQ(text(encode(SdoWrite{{0x1016, 1}, (127U << 16) | 250U, 4}, 3)), "603#23161001FA007F00");
  EXPECT_EQ(text(encode(SdoWrite{{0x6060, 0}, 0xFFFFFF08, 1}, 3)), "603#2F60600008000000");  // cut to its size
  const auto decoded = decode_sdo_write(frame("603#23161001FA007F00"), 3);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->value, 0x7F00FAU);
  EXPECT_EQ(decoded->size, 4);
}

TEST(CanFrames, SdoWriteAnswer) {
  EXPECT_EQ(text(encode(SdoWriteAnswer{{0x6060, 0}}, 3)), "583#6060600000000000");
  EXPECT_EQ(decode_sdo_write_answer(frame("583#6060600000000000"), 3)->object, (ObjectAddress{0x6060, 0}));
}

TEST(CanFrames, SdoAbortBothWays) {
  EXPECT_EQ(text(encode_answer_abort({{0x605A, 0}, 0x06090030}, 3)), "583#805A600030000906");
  EXPECT_EQ(text(encode_request_abort({{0x605A, 0}, 0x05040000}, 3)), "603#805A600000000405");
  const auto decoded = decode_sdo_answer_abort(frame("583#805A600030000906"), 3);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->code, 0x06090030U);
}

TEST(CanFrames, EveryAbortCodeOfTheTableHasItsOwnText) {
  std::vector<std::string> texts;
  for (const std::uint32_t code :
       {0x05030000U, 0x05040000U, 0x05040001U, 0x06010000U, 0x06010001U, 0x06010002U, 0x06020000U, 0x06040041U,
        0x06040042U, 0x06070010U, 0x06070012U, 0x06070013U, 0x06090011U, 0x06090030U, 0x06090031U, 0x06090032U,
        0x08000000U, 0x08000020U, 0x08000021U, 0x08000022U})
    texts.emplace_back(sdo_abort_text(code));
  std::sort(texts.begin(), texts.end());
  EXPECT_EQ(std::unique(texts.begin(), texts.end()), texts.end());
  EXPECT_EQ(std::count(texts.begin(), texts.end(), "unknown SDO abort code"), 0);
  EXPECT_STREQ(sdo_abort_text(0x12345678), "unknown SDO abort code");
}

TEST(CanFrames, RefuseAnotherNodeAnotherSizeAndNodeZero) {
  const CanFrame good = encode(Tpdo1{0x27, 1, 0}, 3);
  EXPECT_FALSE(decode_tpdo1(good, 4));
  EXPECT_FALSE(decode_rpdo1(good, 3));
  CanFrame shorter = good;
  shorter.size = 6;
  EXPECT_FALSE(decode_tpdo1(shorter, 3));
  EXPECT_FALSE(decode_emcy(frame("080#0000000000000000"), 0));  // that identifier is SYNC
}

TEST(DriveState, FollowsTheTableOfStatuswords) {
  struct Row { std::uint16_t statusword; DriveState state; };
  for (const Row& row : {Row{0x0000, DriveState::kNotReady}, Row{0x0040, DriveState::kSwitchOnDisabled},
                         Row{0x0021, DriveState::kReadyToSwitchOn}, Row{0x0023, DriveState::kSwitchedOn},
                         Row{0x0027, DriveState::kOperationEnabled}, Row{0x0007, DriveState::kQuickStopActive},
                         Row{0x000F, DriveState::kFaultReaction}, Row{0x0008, DriveState::kFault}}) {
    EXPECT_EQ(drive_state(row.statusword), row.state) << to_text(row.state);
    // Voltage, warning, vendor and upper bits tell nothing about the state.
    EXPECT_EQ(drive_state(static_cast<std::uint16_t>(row.statusword | 0xFF90)), row.state) << to_text(row.state);
  }
  EXPECT_EQ(drive_state(0x0060), DriveState::kSwitchOnDisabled);  // bit 5 does not matter there
  EXPECT_EQ(drive_state(0x0028), DriveState::kFault);
  EXPECT_EQ(drive_state(0x0003), DriveState::kUnknown);
}

TEST(WorstCaseBits, MatchTheBusBudget) {
  EXPECT_EQ(worst_case_bits(0), 55);
  EXPECT_EQ(worst_case_bits(1), 65);
  EXPECT_EQ(worst_case_bits(6), 115);
  EXPECT_EQ(worst_case_bits(8), 135);
}

}  // namespace
}  // namespace armsight
