#include "arm_controller/node_script.hpp"

#include <cassert>

namespace armsight::arm {
namespace {

constexpr std::uint32_t kInvalid = 0x80000000;  ///< bit 31 of a COB-ID: the PDO is off
constexpr std::uint32_t kNoRtr = 0x40000000;

class Builder {
 public:
  explicit Builder(NodeScript& script) : script_(script) {}

  void compare(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value, std::uint32_t mask) {
    add({{index, sub}, size, StepKind::kCompare, value, mask});
  }
  void store(std::uint16_t index, std::uint8_t sub, StoreSlot slot) {
    ScriptStep step{{index, sub}, 4, StepKind::kStore};
    step.on_abort = OnAbort::kSkip;
    step.slot = slot;
    add(step);
  }
  void text(std::uint16_t index) {
    ScriptStep step{{index, 0}, 4, StepKind::kText};
    step.on_abort = OnAbort::kSkip;
    add(step);
  }
  void optional(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
    write(index, sub, size, value, StepKind::kWriteBack, OnAbort::kDegrade);
  }
  void write(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value,
             StepKind kind = StepKind::kWriteBack, OnAbort on_abort = OnAbort::kFault, std::uint32_t fall_back = 0) {
    add({{index, sub}, size, kind, value, 0xFFFFFFFF, on_abort, fall_back});
  }

 private:
  void add(const ScriptStep& step) {
    assert(script_.count < script_.steps.size());
    script_.steps[script_.count++] = step;
  }
  NodeScript& script_;
};

constexpr std::uint32_t mode_bit(DriveMode mode) { return 1u << (static_cast<unsigned>(mode) - 1); }

void add_identity(Builder& b, const ScriptOptions& o) {
  const std::uint32_t modes = mode_bit(o.mode) | (o.homing_method != 0 ? mode_bit(DriveMode::kHoming) : 0);
  b.compare(0x1000, 0, 4, 0x0192, 0xFFFF);                    // profile 402
  b.compare(0x6502, 0, 4, modes, modes);
  for (std::uint8_t sub = 1; sub <= 4; ++sub) b.store(0x1018, sub, static_cast<StoreSlot>(kVendor + sub - 1));
  b.text(0x1008);
  b.store(0x608F, 1, kEncoderCounts);
  b.store(0x608F, 2, kEncoderTurns);
  b.store(0x6091, 1, kGearMotor);
  b.store(0x6091, 2, kGearShaft);
  b.store(0x6076, 0, kRatedTorque);
}

void add_reactions(Builder& b) {
  b.optional(0x6007, 0, 2, 3);                                                // connection lost: quick stop
  b.write(0x605A, 0, 2, 6, StepKind::kWriteBack, OnAbort::kFallBack, 2);      // quick stop: ramp, stay powered, hold
  b.optional(0x605E, 0, 2, 2);                                                // fault: quick-stop ramp
  b.optional(0x1029, 1, 1, 1);                                                // communication error: NMT state stays
}

void add_homing(Builder& b, const ScriptOptions& o) {
  if (o.homing_method == 0) return;
  b.write(0x607C, 0, 4, 0);
  b.write(0x6098, 0, 1, o.homing_method);
}

void add_pdo_mapping(Builder& b, const ScriptOptions& o) {
  const std::uint32_t rpdo_id = kRpdo1Base + o.node, tpdo_id = (kTpdo1Base + o.node) | kNoRtr;
  b.write(0x1400, 1, 4, rpdo_id | kInvalid, StepKind::kWrite);
  b.write(0x1400, 2, 1, 1);
  b.write(0x1600, 0, 1, 0, StepKind::kWrite);
  b.write(0x1600, 1, 4, 0x60400010);
  b.write(0x1600, 2, 4, o.mode == DriveMode::kCyclicVelocity ? 0x60FF0020 : 0x607A0020);
  b.write(0x1600, 3, 4, 0x60B20010, StepKind::kWriteBack, OnAbort::kShorterRpdo);
  b.write(0x1600, 0, 1, 3);
  b.optional(0x1400, 5, 2, o.rpdo_deadline_ms);
  b.write(0x1400, 1, 4, rpdo_id);
  b.write(0x1800, 1, 4, tpdo_id | kInvalid, StepKind::kWrite);
  b.write(0x1800, 2, 1, 1);
  b.write(0x1A00, 0, 1, 0, StepKind::kWrite);
  b.write(0x1A00, 1, 4, 0x60410010);
  b.write(0x1A00, 2, 4, 0x60640020);
  b.write(0x1A00, 3, 4, 0x60770010);
  b.write(0x1A00, 0, 1, 3);
  b.write(0x1800, 1, 4, tpdo_id);
  b.write(0x1401, 1, 4, (0x300u + o.node) | kInvalid, StepKind::kWrite, OnAbort::kSkip);
  b.write(0x1801, 1, 4, (0x280u + o.node) | kInvalid, StepKind::kWrite, OnAbort::kSkip);
}

void add_timing(Builder& b, const ScriptOptions& o) {
  b.write(0x1019, 0, 1, 10, StepKind::kWriteBack, OnAbort::kSkip);             // our SYNC counts 1 … 10
  b.write(0x1006, 0, 4, o.period_us, StepKind::kWriteBack, OnAbort::kSkip);
  b.optional(0x1016, 1, 4, (std::uint32_t{kControllerNode} << 16) | o.controller_heartbeat_ms);
  b.write(0x1017, 0, 2, o.drive_heartbeat_ms);
  if (o.mode != DriveMode::kCyclicPosition) return;
  const auto period = interpolation_period(1e-6 * o.period_us);
  assert(period);  // a rule of the configuration
  b.write(0x60C2, 1, 1, period->value);
  b.write(0x60C2, 2, 1, static_cast<std::uint8_t>(period->exponent));
}

}  // namespace

NodeScript make_node_script(const ScriptOptions& options) {
  NodeScript script;
  Builder builder(script);
  add_identity(builder, options);
  add_reactions(builder);
  add_pdo_mapping(builder, options);
  add_timing(builder, options);
  add_homing(builder, options);
  if (options.stiffness_object)
    builder.optional(options.stiffness_object->index, options.stiffness_object->sub, 2, options.stiffness_permille);
  builder.write(0x6060, 0, 1, static_cast<std::uint32_t>(options.mode));  // last: never with other settings pending
  return script;
}

}  // namespace armsight::arm
