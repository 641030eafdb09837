#include "arm_controller/black_box_replay.hpp"

#include <cstdio>
#include <cstring>
#include <deque>
#include <fstream>
#include <memory>
#include <vector>

#include "arm_controller/black_box_input.hpp"
#include "arm_controller/build_id.hpp"
#include "arm_controller/control_loop.hpp"
#include "arm_controller/tick_recording.hpp"

namespace armsight::arm {
namespace {

/// A cycle as the file holds it: outputs /tick and the sent ones of /can, inputs /input and the other ones of /can.
struct RecordedCycle {
  wire::TickRecord tick;
  std::vector<wire::CanRecord> sent, received;
  wire::CycleInput input;
};

class ReplayBus final : public CanBus {
 public:
  SendResult send(const CanFrame& frame) noexcept override { return send_on(0, frame); }
  SendResult send_on(std::uint8_t bus, const CanFrame& frame) noexcept override {
    sent.push_back({frame, {}, false, bus});
    const std::size_t i = sent.size() - 1;
    return i < cycle->sent.size() ? static_cast<SendResult>(cycle->sent[i].send_result()) : SendResult::kSent;
  }
  bool receive(BusFrame& out) noexcept override {
    if (next == cycle->received.size()) return false;
    const wire::CanRecord& record = cycle->received[next++];
    out = {};
    out.frame.id = record.id();
    out.frame.size = static_cast<std::uint8_t>(record.data().size());
    std::memcpy(out.frame.data.data(), record.data().data(), out.frame.size);
    out.time = time_from_ns(record.time_ns());
    out.is_own_echo = record.is_own_echo();
    out.frame.is_fd = record.is_fd();
    out.bus = static_cast<std::uint8_t>(record.bus());
    return true;
  }
  BusErrors take_errors() noexcept override {
    const wire::CycleInput& in = cycle->input;
    return {in.error_frames(), in.send_failures(), in.receive_overflows(), in.error_passive(), in.bus_off(), in.lost(),
            static_cast<std::uint8_t>(in.lost_buses()), static_cast<std::uint8_t>(in.bus_off_buses())};
  }
  const std::string& name() const override { return name_; }

  const RecordedCycle* cycle = nullptr;
  std::size_t next = 0;
  std::vector<BusFrame> sent;

 private:
  std::string name_ = "replay";
};

std::string frame_text(std::uint32_t bus, std::uint32_t id, const void* data, std::size_t size) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "%03X#", id);
  std::string text = (bus == 0 ? "" : "bus " + std::to_string(bus) + " ") + digits;
  for (std::size_t i = 0; i < size; ++i) {
    std::snprintf(digits, sizeof digits, "%02X", static_cast<const unsigned char*>(data)[i]);
    text += digits;
  }
  return text;
}

std::string text_of(const wire::CanRecord& f) { return frame_text(f.bus(), f.id(), f.data().data(), f.data().size()); }
std::string text_of(const BusFrame& f) { return frame_text(f.bus, f.frame.id, f.frame.data.data(), f.frame.size); }

std::optional<std::string> difference_of_frames(const RecordedCycle& recorded, const std::vector<BusFrame>& replayed) {
  for (std::size_t i = 0; i < std::max(recorded.sent.size(), replayed.size()); ++i) {
    const std::string a = i < recorded.sent.size() ? text_of(recorded.sent[i]) : "none";
    const std::string b = i < replayed.size() ? text_of(replayed[i]) : "none";
    if (a != b) return "frame sent: recorded " + a + ", replayed " + b;
  }
  return std::nullopt;
}

std::optional<std::string> difference_of_ticks(wire::TickRecord recorded, const wire::TickRecord& replayed) {
  recorded.clear_tick_us();
  if (recorded.SerializeAsString() == replayed.SerializeAsString()) return std::nullopt;
  if (recorded.mode() != replayed.mode())
    return "mode: recorded " + std::to_string(recorded.mode()) + ", replayed " + std::to_string(replayed.mode());
  if (recorded.fault_code() != replayed.fault_code())
    return "fault: recorded " + std::to_string(recorded.fault_code()) + ", replayed " + std::to_string(replayed.fault_code());
  for (int i = 0; i < std::min(recorded.q_command_rad_size(), replayed.q_command_rad_size()); ++i)
    if (recorded.q_command_rad(i) != replayed.q_command_rad(i)) {
      char text[120];
      std::snprintf(text, sizeof text, "command of joint %d: recorded %.17g rad, replayed %.17g rad", i + 1,
                    recorded.q_command_rad(i), replayed.q_command_rad(i));
      return text;
    }
  return "state of the tick: the readings, speeds, torques, model or hand differ";
}

class Replay {
 public:
  Replay(const wire::RecordingInfo& info, const wire::CheckpointRecord& checkpoint) : next_cycle_(checkpoint.cycle() + 1) {
    if (checkpoint.build_id() != build_id() || build_id().empty())
      throw NotReplayable("written by build " + checkpoint.build_id() + ", this is build " + build_id() +
                          ": only the same executable goes through it again");
    if (checkpoint.state().size() != sizeof(LoopState)) throw NotReplayable("its checkpoint has the wrong size");
    robot_ = parse_robot(info.configuration(), "configuration in the black box");
    const StartModel start{{0, robot_.camera_hint_T_C_B, JointVector::Zero(robot_.arm.joint_count())}, {}, ModelSource::kNominal, {}};
    loop_ = std::make_unique<ControlLoop>(robot_, start, bus_, *mailboxes_, *tape_, statistics_);
    loop_->restore(std::as_bytes(std::span(checkpoint.state())));
  }

  /// The first difference of this cycle.
  std::optional<std::string> repeat(const RecordedCycle& cycle, BlackBoxResult& result) {
    const wire::CycleInput& in = cycle.input;
    if (in.cycle() != next_cycle_ || in.is_incomplete())
      throw NotReplayable("cycle " + std::to_string(in.cycle()) + ": something before it or in it was not recorded");
    ++next_cycle_;
    bus_.cycle = &cycle;
    bus_.next = 0;
    bus_.sent.clear();
    loop_->repeat_cycle(time_from_ns(in.time_ns()), in.missed(), inbox_of(in, robot_.arm.joint_count()));
    ++result.cycles;
    result.frames_compared += cycle.sent.size();
    TickRecord record;
    if (!tape_->ticks.pop(record)) throw NotReplayable("no output");
    drain();
    if (auto frames = difference_of_frames(cycle, bus_.sent)) return frames;
    wire::TickRecord replayed;
    to_wire(record, replayed);
    return difference_of_ticks(cycle.tick, replayed);
  }

 private:
  void drain() {
    OrdersRecord orders;
    while (tape_->orders.pop(orders)) continue;
    Event event;
    while (tape_->events.pop(event) || mailboxes_->events.pop(event)) continue;
  }

  std::uint64_t next_cycle_;
  RobotConfig robot_;
  ReplayBus bus_;
  std::unique_ptr<Mailboxes> mailboxes_ = std::make_unique<Mailboxes>();
  std::unique_ptr<Tape> tape_ = std::make_unique<Tape>();
  LoopStatistics statistics_;
  std::unique_ptr<ControlLoop> loop_;
};

template <typename Message>
void parse(const RecordedMessage& recorded, Message& out) {
  if (!out.ParseFromString(recorded.data)) throw NotReplayable(recorded.topic + ": undecodable message");
}

}  // namespace

BlackBoxResult replay_black_box(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw NotReplayable(file.string() + ": cannot be read");
  RecordingReader reader(in);
  wire::RecordingInfo info;
  std::unique_ptr<Replay> replay;
  RecordedCycle cycle;
  RecordedMessage message;
  BlackBoxResult result;
  while (reader.next(message)) {
    if (message.topic == "/info") parse(message, info);
    if (message.topic == "/tick") parse(message, cycle.tick);
    if (message.topic == "/state") {
      wire::CheckpointRecord checkpoint;
      parse(message, checkpoint);
      replay = std::make_unique<Replay>(info, checkpoint);
    }
    if (message.topic == "/can") {
      wire::CanRecord frame;
      parse(message, frame);
      check_frame(frame);
      (frame.is_sent() ? cycle.sent : cycle.received).push_back(frame);
    }
    if (message.topic != "/input") continue;
    if (!replay) throw NotReplayable(file.string() + ": no checkpoint before the first cycle");
    parse(message, cycle.input);
    if (auto what = replay->repeat(cycle, result)) {
      result.difference = "cycle " + std::to_string(cycle.input.cycle()) + ": " + *what;
      return result;
    }
    cycle = {};
  }
  if (result.cycles == 0) throw NotReplayable(file.string() + ": holds no cycles with their inputs: no black box");
  return result;
}

}  // namespace armsight::arm
