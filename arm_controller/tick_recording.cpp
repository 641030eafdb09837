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

TickRecording::TickRecording(const std::filesystem::path& file, const wire::RecordingInfo& info)
    : out_(open(file)), writer_(out_, {"arm_controller", 256 * 1024}),
      info_(writer_.add_channel("/info", "armsight.wire.RecordingInfo")),
      tick_(writer_.add_channel("/tick", "armsight.wire.TickRecord")),
      link_(writer_.add_channel("/link", "armsight.wire.LinkRecord")),
      can_(writer_.add_channel("/can", "armsight.wire.CanRecord")) {
  info.SerializeToString(&buffer_);
  writer_.write(info_, time_from_ns(info.time_ns()), buffer_);
}

void TickRecording::write(const TickRecord& record) {
  const ArmSnapshot& s = record.state;
  wire::TickRecord out;
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
  out.set_tick_us(record.tick_us);
  out.SerializeToString(&buffer_);
  writer_.write(tick_, record.cycle_time, buffer_);
}

void TickRecording::write_frames(const TickRecord& record) {
  for (std::size_t i = 0; i < record.frame_count; ++i) {
    const BusFrame& frame = record.frames[i].frame;
    wire::CanRecord out;
    out.set_time_ns(to_ns(frame.time));
    out.set_id(frame.frame.id);
    out.set_data(frame.frame.data.data(), frame.frame.size);
    out.set_is_sent(record.frames[i].is_sent);
    out.SerializeToString(&buffer_);
    writer_.write(can_, frame.time, buffer_);
  }
}

void TickRecording::write(const wire::LinkRecord& record) {
  record.SerializeToString(&buffer_);
  writer_.write(link_, time_from_ns(record.time_ns()), buffer_);
}

}  // namespace armsight::arm
