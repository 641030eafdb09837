// One MIT / DAMIAO drive as the controller sees it (controller.md §4.6): registers asked and set, power, samples,
// supervision. Advanced once a cycle, never waits. Angles are of the drive's output, before sign and zero.
//
//   kAbsent ──register answered──► kConfiguring ──registers read back──► kStarting ──three samples──► kReady
//                                                                        (an old "commands lost" is cleared here)
//   power on: enable each cycle until the samples say so, then commands; quick stop: a ramp to rest, then holds, powered.
//
// A drive that hears nothing for its time-out lets go: it neither brakes nor holds. The self-check says so.
#pragma once

#include <array>
#include <optional>

#include "arm_controller/fault.hpp"
#include "arm_controller/joint_io.hpp"
#include "arm_controller/node.hpp"
#include "arm_controller/self_check.hpp"
#include "protocol/mit_frames.hpp"

namespace armsight::arm {

struct MitOptions {
  std::uint8_t motor = 0;
  MitConfig drive;
  double period_s = 0.004;
  double timeout_s = 0.02;     ///< the drive's own: it lets go after so long without commands
  Duration state_timeout = std::chrono::milliseconds(200);
};

class MitDrive {
 public:
  static constexpr Duration kAbsentAfter = std::chrono::seconds(3);
  static constexpr Duration kAnswerTimeout = std::chrono::milliseconds(100);
  static constexpr Duration kStartTimeout = std::chrono::milliseconds(500);
  static constexpr int kAttempts = 3;
  static constexpr int kMissedLimit = 3;
  static constexpr int kSamplesToStart = 3;
  static constexpr double kQuickStop_rad_s2 = 20.0;

  explicit MitDrive(const MitOptions& options) noexcept;

  /// end: of the frame on the wire.
  void receive(const CanFrame& frame, Time end) noexcept;
  /// After all frames of a cycle; is_due: a sample should have come.
  void advance(Time now, bool is_due, PowerRequest power) noexcept;
  /// This cycle's frame: command, order or the wish for a sample; nullopt while its registers are asked.
  std::optional<CanFrame> set_target(const DriveTarget& target) noexcept;
  /// A register asked for, or set.
  std::optional<CanFrame> service_frame(Time now) noexcept;

  /// Between two calls of advance(): somebody else failed just now.
  void stop(Time now) noexcept {
    if (phase_ == NodePhase::kReady) advance_power(now, PowerRequest::kQuickStop);
  }
  void restart(Time now) noexcept;  ///< from the beginning
  void recover(Time now) noexcept;  ///< the same, with leave to reset the drive's own fault

  std::uint8_t id() const noexcept { return options_.motor; }
  NodePhase phase() const noexcept { return phase_; }
  bool is_following() const noexcept { return phase_ == NodePhase::kReady && sample_.state == MitState::kEnabled; }
  const NodeCheck& check() const noexcept { return check_; }
  const Fault& fault() const noexcept { return fault_; }
  bool has_feedback() const noexcept { return has_sample_; }
  bool is_fresh() const noexcept { return is_fresh_; }
  /// Carried to that instant by the sample's own speed.
  double position_rad(Time at) const noexcept;
  /// The code that the drive sent.
  std::int32_t position_counts() const noexcept;
  double torque_Nm() const noexcept { return sample_.torque_Nm; }
  /// Its encoder is absolute within one turn: whole turns are added to what it says.
  void set_turns(int turns) noexcept;

 private:
  enum class Job : std::uint8_t { kNone, kRead, kWrite, kReadBack };

  void latch(const Fault& fault) noexcept;
  void latch(FaultCode code, MitRegister reg, std::uint32_t got, std::uint32_t wanted) noexcept;
  void latch_state(FaultCode code) noexcept;
  bool take_answer(const CanFrame& frame) noexcept;
  void take_value(std::uint32_t value) noexcept;
  void next_step() noexcept;
  void start(Job job) noexcept;
  void advance_registers(Time now) noexcept;
  void advance_start(Time now) noexcept;
  void advance_power(Time now, PowerRequest power) noexcept;
  void supervise_samples(Time now, bool is_due) noexcept;
  void take_stiffness(std::uint16_t permille) noexcept;
  CanFrame command(double position_rad, double speed_rad_s) const noexcept;
  CanFrame hold() noexcept;
  CanFrame framed(CanFrame frame) const noexcept;
  double offset_rad() const noexcept;

  MitOptions options_;
  NodePhase phase_ = NodePhase::kAbsent;
  Fault fault_;
  NodeCheck check_;

  std::size_t step_ = 0;
  Job job_ = Job::kNone;
  bool is_asked_ = false;         ///< the request is out
  int attempts_ = 0;
  Time asked_{};

  MitSample sample_{};
  bool has_sample_ = false, sample_arrived_ = false, is_fresh_ = false;
  int missed_ = 0, samples_seen_ = 0, turns_ = 0;
  Time sample_time_{};
  std::optional<Time> phase_since_;

  PowerRequest power_ = PowerRequest::kOff;
  Time power_since_{};
  bool was_enabled_ = false, may_clear_ = false;
  std::optional<double> held_rad_;        ///< where it holds, or the ramp of a stop has come to; of the drive's own count
  double stop_speed_rad_s_ = 0.0;
  std::optional<double> last_target_rad_;
  double torque_Nm_ = 0.0, kp_Nm_rad_ = 0.0, kd_Nms_rad_ = 0.0;  ///< of this cycle
};

}  // namespace armsight::arm
