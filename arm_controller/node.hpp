// One drive as the controller sees it: bring-up, power state machine, supervision. Advanced once a cycle, never waits.
//
//   kAbsent ──seen──► kConfiguring ──script done──► kStarting ──three TPDO1──► kReady ⇄ (402 states) enabled
//      ▲                    │ NMT pre-operational          │ NMT start            │
//      └──── restart() ─────┴──────────── a fault latches and stays until restart() or recover() ─────────────┘
#pragma once

#include <array>
#include <optional>

#include "arm_controller/fault.hpp"
#include "arm_controller/joint_io.hpp"
#include "arm_controller/node_script.hpp"
#include "arm_controller/self_check.hpp"
#include "arm_controller/sdo_client.hpp"

namespace armsight::arm {

enum class NodePhase : std::uint8_t { kAbsent, kConfiguring, kStarting, kReady };

struct NodeOptions {
  ScriptOptions script;
  double counts_per_turn = 0.0;  ///< 0: not compared (the hand)
  double gear = 1.0;             ///< of these, what the drive does not tell
  std::optional<ObjectAddress> stiffness_object;
  double period_s = 0.004;
  Duration heartbeat_lost_after = std::chrono::milliseconds(250);
  Duration state_timeout = std::chrono::milliseconds(200);  ///< each state of the power machine
};

class Node {
 public:
  static constexpr Duration kProbeAfter = std::chrono::milliseconds(300);
  static constexpr Duration kAbsentAfter = std::chrono::seconds(3);
  static constexpr Duration kStartTimeout = std::chrono::milliseconds(500);
  static constexpr Duration kHomingTimeout = std::chrono::seconds(2);
  static constexpr int kMissedFeedbackLimit = 3;
  static constexpr int kEmergencyStorm = 50;        ///< within a second
  static constexpr int kFeedbackToStart = 3;

  explicit Node(const NodeOptions& options) noexcept;

  void receive(const CanFrame& frame, Time now) noexcept;
  /// After all frames of a cycle; sync_answered: a SYNC went out since the last call, so a TPDO1 was due.
  void advance(Time now, bool sync_answered, PowerRequest power) noexcept;
  /// RPDO1 for this cycle; nullopt: the node takes none now. target_counts counts only once it follows.
  std::optional<CanFrame> set_point(std::int32_t target_counts, std::int32_t bend_counts = 0) noexcept;
  /// The same of a joint, in the terms of position_rad().
  std::optional<CanFrame> set_target(const DriveTarget& target) noexcept;
  /// One asynchronous frame, after the RPDOs.
  std::optional<CanFrame> service_frame(Time now) noexcept;

  /// Quick stop in this cycle already: another node has failed.
  void stop(Time now) noexcept;
  void restart(Time now) noexcept;      ///< from the beginning
  void recover(Time now) noexcept;      ///< forgets the fault; resets the drive or configures it again
  /// Grip limit, ‰ of the rated torque (0x6072); sent when it changes.
  void set_torque_limit(std::uint16_t permille) noexcept { torque_limit_.wanted = permille; }
  bool torque_limit_is_set() const noexcept { return torque_limit_.taken == torque_limit_.wanted; }

  std::uint8_t id() const noexcept { return options_.script.node; }
  NodePhase phase() const noexcept { return phase_; }
  bool is_following() const noexcept;   ///< enabled and heeding its target
  /// Its counts mean nothing yet: it will be told "here is zero" when it is enabled.
  bool needs_homing() const noexcept { return options_.script.homing_method != 0 && !is_homed_; }
  bool is_homed_by_us() const noexcept { return options_.script.homing_method != 0; }
  const NodeCheck& check() const noexcept { return check_; }
  bool is_resetting() const noexcept { return is_resetting_; }
  const Fault& fault() const noexcept { return fault_; }
  bool has_feedback() const noexcept { return has_feedback_; }
  bool is_fresh() const noexcept { return is_fresh_; }  ///< a TPDO1 came in this cycle
  /// Of the drive's output, before sign and zero; every node samples at the SYNC.
  double position_rad(Time) const noexcept;
  double torque_Nm() const noexcept { return 1e-3 * torque_permille() * rated_torque_Nm(); }
  std::int32_t position_counts() const noexcept { return feedback_.position_counts; }
  double torque_permille() const noexcept { return feedback_.torque; }
  double rated_torque_Nm() const noexcept { return 1e-3 * stored_[kRatedTorque]; }  ///< 0: the drive does not say
  DriveState drive_state_now() const noexcept { return drive_state(feedback_.statusword); }
  bool stays_powered_on_quick_stop() const noexcept { return !fell_back_; }
  Time feedback_time() const noexcept { return feedback_time_; }

 private:
  enum class HomingStep : std::uint8_t { kNone, kToHomingMode, kToEnabled, kHoming, kToReady, kToWorkingMode };

  void latch(FaultCode code, const ObjectAddress& object = {}, std::uint32_t detail = 0,
             std::uint32_t expected = 0) noexcept;
  void latch(const Fault& fault) noexcept;
  void latch_silence(FaultCode code, std::optional<Time> last, Time now) noexcept;
  void latch_drive(FaultCode code) noexcept;
  void take_emergency(const Emcy& emergency, Time now) noexcept;
  void see(Time now) noexcept;
  void begin_check() noexcept;
  void supervise(Time now, bool sync_answered) noexcept;
  void advance_script(Time now) noexcept;
  void take_result(const ScriptStep& step) noexcept;
  void take_abort(const ScriptStep& step) noexcept;
  void start_step(const ScriptStep& step) noexcept;
  void next_step() noexcept;
  struct Setting;
  void keep_setting(Setting& setting) noexcept;
  bool check_counts() noexcept;
  bool check_supervision() noexcept;
  void note_identity() noexcept;
  void note_shortfall(const Shortfall& shortfall) noexcept;
  bool lacks(ObjectAddress object) const noexcept;
  void keep_name() noexcept;
  void advance_power(Time now, PowerRequest power) noexcept;
  void supervise_power(DriveState state, bool state_is_old) noexcept;
  void advance_reset(Time now) noexcept;
  void advance_absent(Time now) noexcept;
  std::uint16_t command_for(PowerRequest power, DriveState state, bool state_is_old) noexcept;
  void advance_homing(Time now) noexcept;
  void enter_homing(HomingStep step, Time now) noexcept;
  void leave_homing() noexcept;
  bool switches_mode(DriveMode mode) noexcept;
  std::int32_t velocity_counts_s(std::int32_t target_counts) noexcept;
  std::uint16_t profile_bits(std::int32_t target_counts) noexcept;

  NodeOptions options_;
  NodeScript script_;
  SdoClient sdo_;
  NodePhase phase_ = NodePhase::kAbsent;
  Fault fault_;
  std::size_t step_ = 0;
  bool reads_back_ = false, uses_fall_back_ = false, fell_back_ = false, has_torque_offset_ = true;
  std::array<std::uint32_t, kStoreSlots> stored_{};
  std::optional<Nmt> nmt_to_send_;
  NodeCheck check_;

  std::optional<Time> phase_since_, heartbeat_time_;
  Tpdo1 feedback_{};
  bool has_feedback_ = false, feedback_arrived_ = false, is_fresh_ = false;
  int missed_feedback_ = 0, feedback_seen_ = 0;
  Time feedback_time_{};
  std::uint16_t emergency_ = 0;
  std::uint8_t error_register_ = 0;
  int emergencies_ = 0;                 ///< since emergencies_since_
  Time emergencies_since_{};

  std::uint16_t controlword_ = kDisableVoltage;
  DriveState last_state_ = DriveState::kUnknown;
  Time state_since_{};
  bool was_enabled_ = false, is_resetting_ = false;
  Time reset_since_{};
  HomingStep homing_ = HomingStep::kNone;
  Time homing_since_{};
  bool is_homed_ = false;
  std::optional<std::int32_t> last_target_;       ///< cyclic velocity: of the cycle before
  std::optional<std::int32_t> profile_target_;    ///< profile position: the one that the drive has taken
  bool profile_is_new_ = false;                   ///< controlword bit 4 is up
  /// A 16-bit object that may be written at any time: as wanted, as the drive took it, as it is being written.
  struct Setting {
    ObjectAddress object;
    std::optional<std::uint16_t> wanted, taken, in_flight;
  };
  Setting torque_limit_{{0x6072, 0}, {}, {}, {}}, stiffness_{};
};

}  // namespace armsight::arm
