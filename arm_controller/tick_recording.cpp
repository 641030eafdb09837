#include "arm_controller/tick_recording.hpp"

#include <stdexcept>

#include "arm_controller/link_reports.hpp"
#include "protocol/convert.hpp"

namespace armsight::arm {
namespace {

std::ofstream open(const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
  return out;
}

}  // namespace

void to_wire(const CycleRecord& record, wire::TickRecord& out) {
  const ArmSnapshot& s = record.state;
  out.set_arm_time_ns(to_ns(s.time));
  out.set_cycle(record.cycle);
  out.set_mode(to_wire(s.mode));
  armsight::to_wire(s.q_reading_rad, out.mutable_q_reading_rad());
  armsight::to_wire(s.speed_rad_s, out.mutable_speed_rad_s());
  armsight::to_wire(s.torque_Nm, out.mutable_torque_nm());
  armsight::to_wire(s.q_command_rad, out.mutable_q_command_rad());
  out.set_model_revision(s.model.revision);
  out.set_goal(s.goal);
  out.set_fault_code(static_cast<std::uint32_t>(s.fault.code));
  out.set_hand_closure(s.hand_closure);
  out.set_hand_command(s.hand_command);
  out.set_hand_effort_permille(s.hand_effort_permille);
  out.set_is_still(s.is_still);
}

TickRecording::TickRecording(const std::filesystem::path& file, const wire::RecordingInfo& info)
    : out_(open(file)), writer_(out_, {"arm_controller", 256 * 1024}),
      info_(writer_.add_channel("/info", "armsight.wire.RecordingInfo")),
      tick_(writer_.add_channel("/tick", "armsight.wire.TickRecord")),
      link_(writer_.add_channel("/link", "armsight.wire.LinkRecord")),
      can_(writer_.add_channel("/can", "armsight.wire.CanRecord")) {
  info.SerializeToString(&buffer_);
  writer_.write(info_, time_from_ns(info.time_ns()), buffer_);
}

void TickRecording::write(const CycleRecord& record) {
  wire::TickRecord out;
  to_wire(record, out);
  out.set_tick_us(record.tick_us);
  out.SerializeToString(&buffer_);
  writer_.write(tick_, record.cycle_time, buffer_);
}

void TickRecording::write_frames(std::span<const TapeFrame> frames) {
  for (const TapeFrame& kept : frames) {
    wire::CanRecord out;
    out.set_time_ns(to_ns(kept.frame.time));
    out.set_id(kept.frame.frame.id);
    out.set_data(kept.frame.frame.data.data(), kept.frame.frame.size);
    out.set_is_sent(kept.is_sent);
    out.set_is_own_echo(kept.frame.is_own_echo);
    out.set_bus(kept.frame.bus);
    out.set_is_fd(kept.frame.frame.is_fd);
    out.set_send_result(static_cast<std::uint32_t>(kept.result));
    out.SerializeToString(&buffer_);
    writer_.write(can_, kept.frame.time, buffer_);
  }
}

void TickRecording::write(const wire::CheckpointRecord& checkpoint, Time time) {
  if (!state_) state_ = writer_.add_channel("/state", "armsight.wire.CheckpointRecord");
  checkpoint.SerializeToString(&buffer_);
  writer_.write(*state_, time, buffer_);
}

void TickRecording::write(const wire::CycleInput& input, Time time) {
  if (!input_) input_ = writer_.add_channel("/input", "armsight.wire.CycleInput");
  input.SerializeToString(&buffer_);
  writer_.write(*input_, time, buffer_);
}

void TickRecording::write(const wire::LinkRecord& record) {
  record.SerializeToString(&buffer_);
  writer_.write(link_, time_from_ns(record.time_ns()), buffer_);
}

}  // namespace armsight::arm
