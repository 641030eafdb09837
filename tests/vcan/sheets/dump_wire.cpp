// What the code itself says of the wire, for readers that are not ours to compare the data sheets with:
//   object INDEX SUB BYTES ro|rw VALUE      each object that the simulated drive (node 3) answers for
//   frame MESSAGE.HEX SIGNAL=VALUE ...      frames that our code made of these values
//   physical MESSAGE.HEX SIGNAL=VALUE ...   the same, the values rounded to the signals' codes by the encoder
#include <cstdio>
#include <string>

#include "protocol/mit_frames.hpp"
#include "tests/sim/drive_bench.hpp"

namespace {

using namespace armsight;
using armsight::test::DriveBench;

void print_object(DriveBench& bench, ObjectAddress object) {
  const auto answer = decode_sdo_read_answer(bench.ask(encode(SdoRead{object}, DriveBench::kNode)), DriveBench::kNode);
  if (!answer) return;
  constexpr std::uint32_t kReadOnly = 0x06010002;
  const bool is_fixed = DriveBench().write(object.index, object.sub, answer->value, answer->size) == kReadOnly;
  std::printf("object %04X %d %d %s %u\n", object.index, object.sub, answer->size, is_fixed ? "ro" : "rw",
              answer->value);
}

void print_frame(const char* message, const CanFrame& frame, const std::string& signals,
                 const char* kind = "frame") {
  std::printf("%s %s %X ", kind, message, frame.id);
  for (int i = 0; i < frame.size; ++i) std::printf("%02X", frame.data[static_cast<std::size_t>(i)]);
  std::printf(" %s\n", signals.c_str());
}

void print_mit_frames() {
  const MitRanges ranges{12.5, 30.0, 10.0};  // those of the DBC: a DM4310
  print_frame("Joint2_MitCommand", encode(MitCommand{-1.25, 3.5, 80.0, 2.0, -4.5}, 2, ranges),
              "Position=-1.25 Speed=3.5 Kp=80 Kd=2 Torque=-4.5", "physical");
  print_frame("Joint4_MitSample", encode(MitSample{MitState::kWindingHot, 3.75, -12.5, 7.25, 41, 83}, 20, 4, ranges),
              "State=12 Motor=4 Position=3.75 Speed=-12.5 Torque=7.25 PowerStage=41 Winding=83", "physical");
  print_frame("MitRegister", encode_mit_write(MitRegister::kTimeout, 400, 5),
              "Motor=5 Command=85 Register=9 Value=400");
}

}  // namespace

int main() {
  DriveBench bench;
  for (std::uint32_t index = 0x1000; index < 0x7000; ++index)
    for (std::uint8_t sub = 0; sub <= 16; ++sub) print_object(bench, {static_cast<std::uint16_t>(index), sub});
  print_frame("NMT", encode(Nmt{NmtCommand::kPreOperational, 5}), "Command=128 Node=5");
  print_frame("SYNC", encode(Sync{7}), "Counter=7");
  print_frame("Joint2_EMCY", encode(Emcy{0x8130, 0x11}, 2), "ErrorCode=33072 ErrorRegister=17");
  print_frame("Joint3_TPDO1", encode(Tpdo1{0x1237, -123456, -17}, 3), "Statusword=4663 Position=-123456 Torque=-17");
  print_frame("Hand_RPDO1", encode(Rpdo1{0x0F, 16000, -5}, 6), "Controlword=15 TargetPosition=16000 TorqueOffset=-5");
  print_frame("Joint1_SDO_request", encode(SdoWrite{{0x1A00, 2}, 0x60640020, 4}, 1),
              "Command=35 Index=6656 SubIndex=2 Data=1617166368");
  print_frame("Joint5_SDO_answer", encode(SdoReadAnswer{{0x6041, 0}, 0x0240, 2}, 5),
              "Command=75 Index=24641 SubIndex=0 Data=576");
  print_frame("Joint4_Heartbeat", encode(Heartbeat{NmtState::kOperational}, 4), "State=5");
  print_frame("Controller_Heartbeat", encode(Heartbeat{NmtState::kOperational}, kControllerNode), "State=5");
  print_mit_frames();
}
