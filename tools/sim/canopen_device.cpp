#include "tools/sim/canopen_device.hpp"

#include <algorithm>

#include "tools/sim/bus_model.hpp"

namespace armsight::sim {

namespace {

constexpr std::uint32_t kInvalidPdo = 0x80000000;
constexpr std::uint16_t kRpdo = 0x1400, kRpdoMap = 0x1600, kTpdo = 0x1800, kTpdoMap = 0x1A00;
constexpr std::uint32_t kProfile402 = 0x00020192, kVendor = 0x000005A1, kProduct = 1;
constexpr std::uint8_t kMaxMapped = 8;
constexpr std::uint16_t kLabel = 0x2001;       ///< where the owner writes what this drive is for
constexpr std::size_t kMaxLabel = 32;
constexpr std::uint16_t kEmcyHeartbeat = 0x8130, kEmcyRpdoTimeout = 0x8250;
constexpr std::uint8_t kCommunicationError = 0x10;

std::uint16_t index_of(std::uint32_t mapping) { return static_cast<std::uint16_t>(mapping >> 16); }
std::uint8_t sub_of(std::uint32_t mapping) { return static_cast<std::uint8_t>(mapping >> 8); }
int bytes_of(std::uint32_t mapping) { return static_cast<int>(mapping & 0xFF) / 8; }

}  // namespace

CanopenDevice::CanopenDevice(std::uint8_t node, SendFrame send)
    : node_(node),
      send_(std::move(send)),
      next_heartbeat_(kNever),
      heartbeat_deadline_(kNever),
      rpdo_deadline_(kNever) {
  add_communication_objects();
}

void CanopenDevice::add_communication_objects() {
  const auto fixed = [this](std::uint16_t i, std::uint8_t s, std::uint8_t size, std::uint32_t v) {
    objects_.add(i, s, size, Access::kReadOnly, v);
  };
  const auto free = [this](std::uint16_t i, std::uint8_t s, std::uint8_t size, std::uint32_t v) {
    objects_.add(i, s, size, Access::kReadWrite, v);
  };
  fixed(0x1000, 0, 4, kProfile402);
  fixed(0x1001, 0, 1, 0);
  objects_.add_text(0x1008, 0, "Armsight simulated drive");
  objects_.add_text(0x1009, 0, "sim 1");
  objects_.add_text(0x100A, 0, "1.0.0");
  objects_.add_text(kLabel, kMaxLabel, "");
  free(0x1005, 0, 4, kSyncId);
  free(0x1006, 0, 4, 0);
  free(0x1007, 0, 4, 0);
  fixed(0x1016, 0, 1, 1);
  free(0x1016, 1, 4, 0);
  free(0x1017, 0, 2, 500);
  fixed(0x1018, 0, 1, 4);
  fixed(0x1018, 1, 4, kVendor);
  fixed(0x1018, 2, 4, kProduct);
  fixed(0x1018, 3, 4, 1);
  fixed(0x1018, 4, 4, node_);
  free(0x1019, 0, 1, 0);
  fixed(0x1029, 0, 1, 1);
  free(0x1029, 1, 1, 1);
  for (const std::uint16_t pdo : {kRpdo, kTpdo}) {
    const std::uint32_t id = (pdo == kRpdo ? kRpdo1Base : kTpdo1Base) + node_;
    fixed(pdo, 0, 1, 5);
    free(pdo, 1, 4, id | kInvalidPdo);
    free(pdo, 2, 1, 1);
    free(pdo, 5, 2, 0);
    const auto mapping = static_cast<std::uint16_t>(pdo + 0x200);
    for (std::uint8_t sub = 0; sub <= kMaxMapped; ++sub) free(mapping, sub, sub == 0 ? 1 : 4, 0);
    const auto second = static_cast<std::uint16_t>(pdo + 1);  // exists and stays off
    fixed(second, 0, 1, 1);
    free(second, 1, 4, kInvalidPdo);
    fixed(static_cast<std::uint16_t>(mapping + 1), 0, 1, 0);
  }
}

Duration CanopenDevice::milliseconds(std::uint16_t index, std::uint8_t sub) const {
  return std::chrono::milliseconds(objects_.get(index, sub) & 0xFFFF);
}

void CanopenDevice::power_on(Time now) {
  is_on_ = true;
  restart(now);
}

void CanopenDevice::power_off(Time now) {
  forget_all(now);
  next_heartbeat_ = kNever;
  is_on_ = false;
}

bool CanopenDevice::is_missing(ObjectAddress object) const {
  const auto bend = bends_.find({object.index, object.sub});
  return bend != bends_.end() && !bend->second;
}

void CanopenDevice::forget_all(Time now) {
  add_communication_objects();
  reset(now);
  heartbeat_deadline_ = rpdo_deadline_ = kNever;
  pending_rpdo_.reset();
  transfer_.reset();
  state_ = NmtState::kBootUp;
}

void CanopenDevice::restart(Time now) {
  forget_all(now);
  send_(encode(Heartbeat{NmtState::kBootUp}, node_), now);
  state_ = NmtState::kPreOperational;
  next_heartbeat_ = now + milliseconds(0x1017, 0);
}

void CanopenDevice::on_frame(const CanFrame& frame, Time now) {
  if (!is_on_) return;
  if (const auto nmt = decode_nmt(frame)) return on_nmt(*nmt, now);
  if (frame.id >= kHeartbeatBase) return on_heartbeat(frame, now);
  if (state_ == NmtState::kStopped) return;
  if (frame.id == (objects_.get(0x1005) & 0x7FF)) return on_sync_frame(now);
  if (frame.id == kSdoRequestBase + node_) return on_sdo(frame, now);
  if (pdo_is_valid(kRpdo) && frame.id == (objects_.get(kRpdo, 1) & 0x7FF)) take_rpdo(frame, now);
}

void CanopenDevice::on_nmt(const Nmt& command, Time now) {
  if (command.node != 0 && command.node != node_) return;
  switch (command.command) {
    case NmtCommand::kStart: return set_state(NmtState::kOperational, now);
    case NmtCommand::kStop: return set_state(NmtState::kStopped, now);
    case NmtCommand::kPreOperational: return set_state(NmtState::kPreOperational, now);
    case NmtCommand::kResetNode:
    case NmtCommand::kResetCommunication: return restart(now);
  }
}

void CanopenDevice::set_state(NmtState state, Time now) {
  const bool is_leaving = state_ == NmtState::kOperational && state != NmtState::kOperational;
  state_ = state;
  if (!is_leaving) return;
  rpdo_deadline_ = kNever;
  pending_rpdo_.reset();
  lose(Loss::kNotOperational, now);
}

/// The sample is taken first, then what was received since the last SYNC acts: a set-point never changes the sample
/// that left with it.
void CanopenDevice::on_sync_frame(Time now) {
  if (state_ != NmtState::kOperational) return;
  on_sync(now);
  if (pdo_is_valid(kTpdo)) send_tpdo(now);
  if (pending_rpdo_) apply_rpdo(now);
}

void CanopenDevice::on_heartbeat(const CanFrame& frame, Time now) {
  const std::uint32_t watched = objects_.get(0x1016, 1);
  const std::uint32_t watched_node = (watched >> 16) & 0x7F;
  if (watched_node == 0 || (watched & 0xFFFF) == 0 || frame.id != kHeartbeatBase + watched_node) return;
  heartbeat_deadline_ = now + milliseconds(0x1016, 1);
}

void CanopenDevice::take_rpdo(const CanFrame& frame, Time now) {
  if (state_ != NmtState::kOperational) return;
  pending_rpdo_ = frame;
  const Duration deadline = milliseconds(kRpdo, 5);
  if (deadline > Duration::zero()) rpdo_deadline_ = now + deadline;
  const std::uint32_t transmission = objects_.get(kRpdo, 2);
  if (transmission > 240) apply_rpdo(now);
}

void CanopenDevice::apply_rpdo(Time now) {
  const CanFrame frame = *pending_rpdo_;
  pending_rpdo_.reset();
  int at = 0;
  for (std::uint8_t i = 1; i <= objects_.get(kRpdoMap); ++i) {
    const std::uint32_t mapping = objects_.get(kRpdoMap, i);
    if (at + bytes_of(mapping) > frame.size) return;  // shorter than mapped: not ours to guess
    std::uint32_t value = 0;
    for (int byte = bytes_of(mapping) - 1; byte >= 0; --byte)
      value = (value << 8) | frame.data[static_cast<std::size_t>(at + byte)];
    objects_.set({index_of(mapping), sub_of(mapping)}, value);
    at += bytes_of(mapping);
  }
  act(now);
}

void CanopenDevice::send_tpdo(Time now) {
  CanFrame frame;
  frame.id = objects_.get(kTpdo, 1) & 0x7FF;
  for (std::uint8_t i = 1; i <= objects_.get(kTpdoMap); ++i) {
    const std::uint32_t mapping = objects_.get(kTpdoMap, i);
    std::uint32_t value = value_of({index_of(mapping), sub_of(mapping)});
    for (int byte = 0; byte < bytes_of(mapping); ++byte, value >>= 8)
      frame.data[frame.size++] = static_cast<std::uint8_t>(value);
  }
  send_(frame, now);
}

void CanopenDevice::send_heartbeat(Time now) {
  const Duration period = milliseconds(0x1017, 0);
  next_heartbeat_ = period > Duration::zero() ? now + period : kNever;
  if (period > Duration::zero()) send_(encode(Heartbeat{state_}, node_), now);
}

void CanopenDevice::send_emergency(std::uint16_t code, std::uint8_t error_register, Time now) {
  objects_.set({0x1001, 0}, error_register);
  send_(encode(Emcy{code, error_register}, node_), now);
}

Time CanopenDevice::next_time() const { return std::min({next_heartbeat_, heartbeat_deadline_, rpdo_deadline_}); }

void CanopenDevice::excuse(Duration stall) {
  if (heartbeat_deadline_ != kNever) heartbeat_deadline_ += stall;
  if (rpdo_deadline_ != kNever) rpdo_deadline_ += stall;
}

void CanopenDevice::on_time(Time now) {
  if (now >= next_heartbeat_) send_heartbeat(now);
  if (now >= heartbeat_deadline_) {
    heartbeat_deadline_ = kNever;  // watched again from the next heartbeat on
    send_emergency(kEmcyHeartbeat, kCommunicationError, now);
    lose(Loss::kHeartbeat, now);
  }
  if (now >= rpdo_deadline_) {
    rpdo_deadline_ = kNever;
    send_emergency(kEmcyRpdoTimeout, kCommunicationError, now);
    lose(Loss::kSetPoints, now);
  }
}

std::uint32_t CanopenDevice::value_of(ObjectAddress object) {
  const auto bend = bends_.find({object.index, object.sub});
  if (bend != bends_.end() && bend->second) return *bend->second;
  const auto live = live_value(object);
  return live ? *live : objects_.get(object.index, object.sub);
}

bool CanopenDevice::pdo_is_valid(std::uint16_t communication) const {
  return (objects_.get(communication, 1) & kInvalidPdo) == 0;
}

}  // namespace armsight::sim
