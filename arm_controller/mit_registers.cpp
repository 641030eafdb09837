// MitDrive, second part: what is asked of a drive's registers before it may move. One request at a time, 100 ms for each
// answer, three attempts. Written values are of its working memory: they are gone with its power.
#include <array>
#include <bit>
#include <cmath>

#include "arm_controller/mit_drive.hpp"

namespace armsight::arm {
namespace {

enum class Wish : std::uint8_t {
  kKeep,    ///< read, for people
  kSame,    ///< read, a float, must be as configured
  kEnsure,  ///< read; where it differs written and read back
};

struct MitStep {
  MitRegister reg;
  Wish wish;
  std::uint32_t value = 0;
};
constexpr std::size_t kMitSteps = 6;
constexpr float kRangeTolerance = 1e-3F;  ///< relative

std::uint32_t float_bits(double value) noexcept { return std::bit_cast<std::uint32_t>(static_cast<float>(value)); }

/// The mode first: a drive in another one answers registers and no command.
MitStep mit_step(const MitOptions& o, std::size_t i) noexcept {
  const MitRanges& ranges = o.drive.ranges;
  switch (i) {
    case 0: return {MitRegister::kControlMode, Wish::kEnsure, kMitMode};
    case 1:
      return {MitRegister::kTimeout, Wish::kEnsure, static_cast<std::uint32_t>(std::lround(o.timeout_s / kMitTimeoutUnit_s))};
    case 2: return {MitRegister::kPositionRange, Wish::kSame, float_bits(ranges.position_rad)};
    case 3: return {MitRegister::kSpeedRange, Wish::kSame, float_bits(ranges.speed_rad_s)};
    case 4: return {MitRegister::kTorqueRange, Wish::kSame, float_bits(ranges.torque_Nm)};
    default: return {MitRegister::kVersion, Wish::kKeep};
  }
}

bool is_same_float(std::uint32_t a, std::uint32_t b) noexcept {
  const auto x = std::bit_cast<float>(a), y = std::bit_cast<float>(b);
  return std::abs(x - y) <= kRangeTolerance * std::abs(y);  // NaN is not
}

}  // namespace

void MitDrive::start(Job job) noexcept {
  job_ = job;
  is_asked_ = false;
  attempts_ = 0;
}

std::optional<CanFrame> MitDrive::service_frame(Time now) noexcept {
  if (job_ == Job::kNone || is_asked_ || fault_.is_set()) return std::nullopt;
  is_asked_ = true;
  asked_ = now;
  ++attempts_;
  const MitStep step = mit_step(options_, step_);
  return framed(job_ == Job::kWrite ? encode_mit_write(step.reg, step.value, id()) : encode_mit_read(step.reg, id()));
}

// A drive that is not there is asked for longer than one that has answered before.
void MitDrive::advance_registers(Time now) noexcept {
  if (job_ == Job::kNone) return start(Job::kRead);
  if (!is_asked_ || now - asked_ < kAnswerTimeout) return;
  is_asked_ = false;
  if (phase_ == NodePhase::kAbsent) {
    if (now - *phase_since_ > kAbsentAfter) latch({FaultCode::kNodeAbsent, id()});
  } else if (attempts_ >= kAttempts) {
    latch(FaultCode::kSdoTimeout, mit_step(options_, step_).reg, 0, 0);
  }
}

bool MitDrive::take_answer(const CanFrame& frame) noexcept {
  if (job_ == Job::kNone || !is_asked_) return false;
  const auto value = decode_mit_answer(frame, options_.drive.reply_id, id(), mit_step(options_, step_).reg, job_ == Job::kWrite);
  if (!value) return false;
  if (phase_ == NodePhase::kAbsent) phase_ = NodePhase::kConfiguring;
  if (job_ == Job::kWrite) start(Job::kReadBack);
  else take_value(*value);
  return true;
}

void MitDrive::take_value(std::uint32_t value) noexcept {
  const MitStep step = mit_step(options_, step_);
  const bool is_read_back = job_ == Job::kReadBack;
  if (step.reg == MitRegister::kControlMode && !is_read_back) {
    check_.is_identified = true;
    check_.mit.mode_found = value;
  }
  if (step.reg == MitRegister::kTimeout) check_.mit.timeout_units = value;
  if (step.reg == MitRegister::kVersion) check_.mit.version = value;
  if (step.wish == Wish::kSame && !is_same_float(value, step.value))
    return latch(FaultCode::kWrongIdentity, step.reg, value, step.value);
  if (step.wish == Wish::kEnsure && value != step.value) {
    if (!is_read_back) return start(Job::kWrite);
    const bool is_off = step.reg == MitRegister::kTimeout && value == 0;
    return latch(is_off ? FaultCode::kNoSupervision : FaultCode::kReadBackDiffers, step.reg, value, step.value);
  }
  next_step();
}

void MitDrive::next_step() noexcept {
  job_ = Job::kNone;
  if (++step_ < kMitSteps) return start(Job::kRead);
  check_.is_mapped = true;
  phase_ = NodePhase::kStarting;
  phase_since_.reset();  // begins with the next advance()
  samples_seen_ = missed_ = 0;
}

}  // namespace armsight::arm
