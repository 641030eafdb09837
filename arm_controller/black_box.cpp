#include "arm_controller/black_box.hpp"

#include <stdexcept>

#include "arm_controller/build_id.hpp"
#include "arm_controller/tick_recording.hpp"

namespace armsight::arm {
namespace {

void put_errors(const BusErrors& e, wire::CycleInput& out) {
  out.set_error_frames(e.error_frames);
  out.set_send_failures(e.send_failures);
  out.set_receive_overflows(e.receive_overflows);
  out.set_error_passive(e.error_passive);
  out.set_bus_off(e.bus_off);
  out.set_lost(e.lost);
  out.set_lost_buses(e.lost_buses);
  out.set_bus_off_buses(e.bus_off_buses);
}

void put_lease(const Lease& lease, wire::CycleInput& out) {
  out.set_has_lease(true);
  out.set_lease_session(lease.session);
  out.set_lease_until_ns(to_ns(lease.until));
  out.set_lease_heard_ns(to_ns(lease.heard));
  out.set_lease_why_free(static_cast<std::uint32_t>(lease.why_free));
}

wire::CycleInput input_of(const CycleRecord& record, const TickInbox* orders) {
  wire::CycleInput out;
  out.set_cycle(record.cycle);
  out.set_time_ns(to_ns(record.cycle_time));
  out.set_missed(record.missed);
  put_errors(record.errors, out);
  out.set_stop(record.stop);
  out.set_model_not_saved(record.model_not_saved);
  if (record.lease) put_lease(*record.lease, out);
  out.set_is_incomplete(record.frames_left_out > 0 || record.has_orders != (orders != nullptr));
  if (orders) out.set_orders(reinterpret_cast<const char*>(&*orders), sizeof *orders);
  return out;
}

}  // namespace

void BlackBox::keep(const TickRecord& record) {
  Cycle cycle{record, {record.frames.begin(), record.frames.begin() + static_cast<std::ptrdiff_t>(record.frame_count)}, {}};
  while (!orders_.empty() && orders_.front().cycle <= record.cycle) {
    if (orders_.front().cycle == record.cycle) cycle.orders = std::make_unique<TickInbox>(orders_.front().inbox);
    orders_.pop_front();
  }
  cycles_.push_back(std::move(cycle));
  forget_old();
}

void BlackBox::keep(const OrdersRecord& orders) { orders_.push_back(orders); }

void BlackBox::keep_checkpoint(std::uint64_t cycle, std::span<const std::byte> state) {
  checkpoints_.push_back({cycle, {state.begin(), state.end()}});
}

// The oldest checkpoint goes when the next one is old enough, and with it the cycles before that.
void BlackBox::forget_old() {
  const std::uint64_t newest = cycles_.back().record.cycle;
  while (checkpoints_.size() > 1 && checkpoints_[1].cycle + kKeptTicks <= newest) checkpoints_.pop_front();
  const bool is_starved = cycles_.size() > kKeptTicks + 2 * kCheckpointEvery;  // no checkpoint came for too long
  while (!cycles_.empty() && (is_starved ? cycles_.size() > kKeptTicks
                                         : !checkpoints_.empty() && cycles_.front().record.cycle <= checkpoints_.front().cycle))
    cycles_.pop_front();
}

void BlackBox::write(const std::filesystem::path& file, const wire::RecordingInfo& info) const {
  const std::filesystem::path unfinished = file.string() + ".part";
  {
    TickRecording box(unfinished, info);
    if (!checkpoints_.empty()) {
      wire::CheckpointRecord checkpoint;
      checkpoint.set_build_id(build_id());
      checkpoint.set_cycle(checkpoints_.front().cycle);
      checkpoint.set_state(checkpoints_.front().state.data(), checkpoints_.front().state.size());
      box.write(checkpoint, cycles_.empty() ? Time{} : cycles_.front().record.cycle_time);
    }
    for (const Cycle& cycle : cycles_) {
      box.write(cycle.record);
      box.write_frames(cycle.frames);
      box.write(input_of(cycle.record, cycle.orders.get()), cycle.record.cycle_time);
    }
    box.flush();
    if (!box.is_good()) throw std::runtime_error(file.string() + ": cannot be written to its end (disk full?)");
  }
  std::filesystem::rename(unfinished, file);
}

}  // namespace armsight::arm
