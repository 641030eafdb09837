// Node, first half: from "seen" to "configured": walks the script, one SDO exchange at a time.
#include <cmath>

#include "arm_controller/node.hpp"

namespace armsight::arm {
namespace {

constexpr std::uint32_t size_mask(std::uint8_t size) { return size >= 4 ? 0xFFFFFFFF : (1u << (8 * size)) - 1; }

}  // namespace

void Node::start_step(const ScriptStep& step) noexcept {
  const bool is_read = reads_back_ || step.kind == StepKind::kCompare || step.kind == StepKind::kStore;
  const bool is_mapping_count = step.object == ObjectAddress{0x1600, 0} && step.value == 3;
  const std::uint32_t value = is_mapping_count && !has_torque_offset_ ? 2 : step.value;
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
    if (!check_counts()) return;
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
  if (step.kind == StepKind::kWriteBack && !reads_back_) {
    reads_back_ = true;
    return sdo_.clear();
  }
  if (reads_back_) {
    const bool is_short_count = step.object == ObjectAddress{0x1600, 0} && !has_torque_offset_;
    const std::uint32_t wanted = uses_fall_back_ ? step.fall_back : is_short_count ? 2 : step.value;
    if (value != (wanted & size_mask(step.size)))
      return latch(FaultCode::kReadBackDiffers, step.object, value, wanted);
  }
  next_step();
}

void Node::take_abort(const ScriptStep& step) noexcept {
  const bool can_fall_back = step.on_abort == OnAbort::kFallBack && !uses_fall_back_;
  if (step.on_abort == OnAbort::kSkip) return next_step();
  if (step.on_abort == OnAbort::kShorterRpdo) {
    has_torque_offset_ = false;
    return next_step();
  }
  if (!can_fall_back) return latch(FaultCode::kSdoAborted, step.object, sdo_.value());
  uses_fall_back_ = fell_back_ = true;
  reads_back_ = false;
  sdo_.clear();
}

// Counts a turn of the joint: encoder resolution times gear ratio; a drive without gear object has none.
bool Node::check_counts() noexcept {
  if (options_.counts_per_turn <= 0.0) return true;
  const auto ratio = [&](StoreSlot over, StoreSlot under) {
    return stored_[under] == 0 ? 1.0 : static_cast<double>(stored_[over]) / stored_[under];
  };
  const double counts = ratio(kEncoderCounts, kEncoderTurns) * ratio(kGearMotor, kGearShaft);
  if (std::abs(counts - options_.counts_per_turn) < 0.5) return true;
  latch(FaultCode::kWrongIdentity, {0x608F, 1}, static_cast<std::uint32_t>(counts),
        static_cast<std::uint32_t>(options_.counts_per_turn));
  return false;
}

}  // namespace armsight::arm
