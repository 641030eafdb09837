// One simulated drive on a table: frames in by hand, frames out in a list, a motor that stands where it is put.
#pragma once

#include <utility>
#include <vector>

#include "tools/sim/drive_node.hpp"

namespace armsight::test {

struct StandingMotor : sim::Motor {
  std::int32_t counts = 1000;
  std::int32_t target = 0;
  sim::MotorMode mode = sim::MotorMode::kOff;

  std::int32_t position_counts() override { return counts; }
  std::int16_t torque_permille() const override { return 12; }
  void command(sim::MotorMode m, std::int32_t t, std::uint16_t) override {
    mode = m;
    target = t;
  }
  std::uint32_t counts_per_turn() const override { return 32768; }
  std::uint32_t following_window_counts() const override { return 1800; }
};

struct DriveBench {
  static constexpr std::uint8_t kNode = 3;
  StandingMotor motor;
  std::vector<CanFrame> sent;
  sim::DriveNode drive{kNode, [this](const CanFrame& frame, Time) { sent.push_back(frame); }, motor};
  Time now = time_from_ns(1'000'000'000);

  DriveBench() { drive.power_on(now); }

  std::vector<CanFrame> take() { return std::exchange(sent, {}); }
  void send(const CanFrame& frame) { drive.on_frame(frame, now); }
  CanFrame ask(const CanFrame& request) {
    take();
    send(request);
    return sent.empty() ? CanFrame{} : sent.back();
  }
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, std::uint8_t size) {
    const CanFrame answer = ask(encode(SdoWrite{{index, sub}, value, size}, kNode));
    if (const auto abort = decode_sdo_answer_abort(answer, kNode)) return abort->code;
    return decode_sdo_write_answer(answer, kNode) ? 0 : 0xFFFFFFFF;
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    const auto answer = decode_sdo_read_answer(ask(encode(SdoRead{{index, sub}}, kNode)), kNode);
    return answer ? answer->value : 0xFFFFFFFF;
  }
  /// The order of controller.md §4.3.
  void configure() {
    for (const std::uint16_t pdo : {std::uint16_t{0x1400}, std::uint16_t{0x1800}}) {
      const bool is_rpdo = pdo == 0x1400;
      const std::uint32_t id = is_rpdo ? 0x203 : 0x183;
      const auto map = static_cast<std::uint16_t>(pdo + 0x200);
      write(pdo, 1, id | 0x80000000, 4);
      write(pdo, 2, 1, 1);
      write(map, 0, 0, 1);
      write(map, 1, is_rpdo ? 0x60400010 : 0x60410010, 4);
      write(map, 2, is_rpdo ? 0x607A0020 : 0x60640020, 4);
      write(map, 3, is_rpdo ? 0x60B20010 : 0x60770010, 4);
      write(map, 0, 3, 1);
      if (is_rpdo) write(pdo, 5, 20, 2);
      write(pdo, 1, id, 4);
    }
    write(0x1016, 1, (127u << 16) | 250, 4);
    write(0x6007, 0, 3, 2);
    write(0x605A, 0, 6, 2);
    write(0x6060, 0, 8, 1);
  }
  void start() { send(encode(Nmt{NmtCommand::kStart, kNode})); }
  void advance(Duration d) {
    const Time end = now + d;
    while (drive.next_time() <= end) {
      now = drive.next_time();
      drive.on_time(now);
    }
    now = end;
  }
  /// RPDO, then 4 ms later the SYNC it acts with; returns the TPDO of that SYNC.
  std::optional<Tpdo1> cycle(std::uint16_t controlword, std::int32_t target) {
    send(encode(Rpdo1{controlword, target, 0}, kNode));
    advance(std::chrono::milliseconds(4));
    take();
    send(encode(Sync{1}));
    for (const CanFrame& frame : sent)
      if (const auto tpdo = decode_tpdo1(frame, kNode)) return tpdo;
    return std::nullopt;
  }
  void enable() {
    for (const std::uint16_t cw : {kShutdown, kSwitchOn, kEnableOperation}) cycle(cw, motor.counts);
  }
};

}  // namespace armsight::test
