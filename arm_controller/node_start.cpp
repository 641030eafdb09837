// Node, first half: from "seen" to "configured": walks the script, one SDO exchange at a time.
#include <algorithm>
#include <cmath>

#include "arm_controller/node.hpp"

namespace armsight::arm {
namespace {

constexpr ObjectAddress kDeadline{0x1400, 5}, kHeartbeatConsumer{0x1016, 1};

/// Of a figure that came from a drive, up to 2^64, for the report.
std::uint32_t clamped(double counts) noexcept { return static_cast<std::uint32_t>(std::min(counts, 4294967295.0)); }

constexpr std::uint32_t size_mask(std::uint8_t size) { return size >= 4 ? 0xFFFFFFFF : (1u << (8 * size)) - 1; }

}  // namespace

void Node::start_step(const ScriptStep& step) noexcept {
  const bool is_write = step.kind == StepKind::kWrite || step.kind == StepKind::kWriteBack;
  const bool is_read = reads_back_ || !is_write;
  const bool is_mapping_count = step.object == ObjectAddress{0x1600, 0} && step.value == 3;
  const std::uint32_t value = is_mapping_count && !has_torque_offset_ ? 2 : step.value;
  if (is_write && !check_.is_identified) note_identity();
  if (is_read) {
    sdo_.start_read(step.object);
  } else {
    sdo_.start_write(step.object, uses_fall_back_ ? step.fall_back : value, step.size);
  }
}

void Node::next_step() noexcept {
  ++step_;
  reads_back_ = uses_fall_back_ = false;
  sdo_.clear();
}

void Node::advance_script(Time now) noexcept {
  if (step_ == script_.count) {
    check_.is_mapped = true;
    if (!check_counts() || !check_supervision()) return;
    nmt_to_send_ = Nmt{NmtCommand::kStart, id()};
    phase_ = NodePhase::kStarting;
    phase_since_ = now;
    feedback_seen_ = missed_feedback_ = 0;
    return;
  }
  const ScriptStep& step = script_.steps[step_];
  switch (sdo_.result()) {
    case SdoResult::kIdle: return start_step(step);
    case SdoResult::kPending: return;
    case SdoResult::kTimedOut: return latch(FaultCode::kSdoTimeout, step.object);
    case SdoResult::kAborted: take_abort(step); break;
    case SdoResult::kDone: take_result(step); break;
  }
  if (!fault_.is_set()) advance_script(now);  // at most once deeper: the next exchange starts in this cycle
}

void Node::take_result(const ScriptStep& step) noexcept {
  const std::uint32_t value = sdo_.value() & size_mask(step.size);
  if (step.kind == StepKind::kCompare && (value & step.mask) != step.value)
    return latch(FaultCode::kWrongIdentity, step.object, value, step.value);
  if (step.kind == StepKind::kStore) stored_[step.slot] = value;
  if (step.kind == StepKind::kText) keep_name();
  if (step.kind == StepKind::kWriteBack && !reads_back_) {
    reads_back_ = true;
    return sdo_.clear();
  }
  if (reads_back_) {
    const bool is_short_count = step.object == ObjectAddress{0x1600, 0} && !has_torque_offset_;
    const std::uint32_t wanted = uses_fall_back_ ? step.fall_back : is_short_count ? 2 : step.value;
    const bool is_equal = value == (wanted & size_mask(step.size));
    const bool may_differ = step.on_abort == OnAbort::kDegrade;
    if (!is_equal && !may_differ) return latch(FaultCode::kReadBackDiffers, step.object, value, wanted);
    if (!is_equal) note_shortfall({step.object, wanted, value, 0});
  }
  next_step();
}

void Node::take_abort(const ScriptStep& step) noexcept {
  const bool can_fall_back = step.on_abort == OnAbort::kFallBack && !uses_fall_back_;
  if (step.on_abort == OnAbort::kSkip) return next_step();
  if (step.on_abort == OnAbort::kShorterRpdo) {
    check_.has_torque_offset = has_torque_offset_ = false;
    return next_step();
  }
  if (can_fall_back || step.on_abort == OnAbort::kDegrade) note_shortfall({step.object, step.value, 0, sdo_.value()});
  if (step.on_abort == OnAbort::kDegrade) return next_step();
  if (!can_fall_back) return latch(FaultCode::kSdoAborted, step.object, sdo_.value());
  uses_fall_back_ = fell_back_ = true;
  reads_back_ = false;
  sdo_.clear();
}

void Node::note_shortfall(const Shortfall& shortfall) noexcept {
  if (check_.shortfall_count < NodeCheck::kMaxShortfalls) check_.shortfalls[check_.shortfall_count++] = shortfall;
}

bool Node::lacks(ObjectAddress object) const noexcept {
  const auto end = check_.shortfalls.begin() + static_cast<std::ptrdiff_t>(check_.shortfall_count);
  return std::find_if(check_.shortfalls.begin(), end, [&](const Shortfall& s) { return s.object == object; }) != end;
}

void Node::keep_name() noexcept {
  check_.name.fill('\0');
  const auto bytes = sdo_.bytes().first(std::min(sdo_.bytes().size(), check_.name.size() - 1));
  std::transform(bytes.begin(), bytes.end(), check_.name.begin(),
                 [](std::uint8_t c) { return c == 0 || (c >= 0x20 && c < 0x7F) ? static_cast<char>(c) : '?'; });
}

// One of the two must tell the drive that we are gone; with neither it would follow its last set-point for ever.
bool Node::check_supervision() noexcept {
  if (!lacks(kDeadline) || !lacks(kHeartbeatConsumer)) return true;
  latch(FaultCode::kNoSupervision);
  return false;
}

void Node::note_identity() noexcept {
  check_.is_identified = true;
  check_.vendor = stored_[kVendor];
  check_.product = stored_[kProduct];
  check_.revision = stored_[kRevision];
  check_.serial = stored_[kSerial];
}

// Counts a turn of the joint: encoder resolution times gear ratio; a drive without gear object has none.
bool Node::check_counts() noexcept {
  const auto ratio = [&](StoreSlot over, StoreSlot under) {
    return stored_[under] == 0 ? 1.0 : static_cast<double>(stored_[over]) / stored_[under];
  };
  const double counts = ratio(kEncoderCounts, kEncoderTurns) * ratio(kGearMotor, kGearShaft);
  check_.counts_per_turn = counts * options_.gear;
  const double wanted = options_.counts_per_turn / options_.gear;
  if (options_.counts_per_turn <= 0.0 || std::abs(counts - wanted) < 0.5) return true;
  latch(FaultCode::kWrongIdentity, {0x608F, 1}, clamped(counts), clamped(wanted));
  return false;
}

}  // namespace armsight::arm
