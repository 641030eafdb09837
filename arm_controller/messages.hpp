// What the link hands to the tick and the tick to the link: plain values, already checked for form and finiteness.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "arm_controller/fault.hpp"
#include "arm_controller/mailbox.hpp"
#include "arm_controller/modes.hpp"
#include "arm_controller/self_check.hpp"
#include "shared/joint_offset_ekf.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

/// Whose message: the answer goes back there.
struct Tag {
  std::uint64_t session = 0;
  std::uint64_t sequence = 0;
};

// ---- link → tick
enum class PowerWish : std::uint8_t { kPowerOff, kHold };
struct ModeOrder {
  Tag tag;
  PowerWish wish = PowerWish::kPowerOff;
  bool clear_fault = false;
  bool quick_stop = false;              ///< with kPowerOff: the drives brake and then hold, powered
};

enum class GoalKind : std::uint8_t { kJoints, kPoseInBase, kPoseInCamera };
struct Goal {
  Tag tag;
  std::uint64_t id = 0;
  GoalKind kind = GoalKind::kJoints;
  JointVector q_real_rad;               ///< the posture: asked for, or what inverse kinematics answered
  Pose T_X_G;                           ///< pose goals: in B or in C
  std::uint64_t model_revision = 0;     ///< pose goals: computed with this one
  double position_tolerance_m = 0.0, orientation_tolerance_rad = 0.0;
  double speed_scale = 1.0;
  int commission_joint = -1;            ///< joint goals: that one alone, not commissioned yet; the others' angles do not count
};

struct HandOrder {
  Tag tag;
  double closure = 0.0;
  std::uint16_t force_limit_permille = 1000;
  double speed_scale = 1.0;
};
struct StiffnessOrder {
  Tag tag;
  std::array<std::uint16_t, kMaxJoints> permille{};
};
struct RecalibrationOrder { Tag tag; bool keep_covariance = false; };
struct Look {
  Tag tag;
  Time capture_time;
  Duration time_bound{};
  HandPoseMeasurement measurement;      ///< q is filled in by the tick, from its own history
};
struct Proposal {
  Tag tag;
  std::uint64_t parent_revision = 0;
  LearnedModel model;                   ///< revision is the tick's to give
  bool has_covariance = false;
  StateMatrix P;
};
/// Until when somebody commands. The tick judges it, so that a stuck link cannot keep the arm moving.
struct Lease {
  std::uint64_t session = 0;
  Time until;
  Time heard{};                                   ///< its holder, last
  FaultCode why_free = FaultCode::kLeaseSilent;   ///< of session 0
};

inline constexpr std::size_t kMaxLooks = 8;

/// What one tick is given.
struct TickInbox {
  bool stop = false;
  bool model_not_saved = false;
  bool is_late = false;                 ///< this cycle began late
  std::optional<Lease> lease;           ///< the newest; session 0: nobody's
  std::optional<ModeOrder> mode;
  std::optional<Goal> goal;
  std::optional<HandOrder> hand;
  std::optional<StiffnessOrder> stiffness;
  std::optional<RecalibrationOrder> recalibration;
  std::optional<Proposal> proposal;
  std::array<Look, kMaxLooks> looks;
  std::size_t look_count = 0;
};

// ---- tick → link
enum class Answer : std::uint8_t {
  kAccepted, kWrongState, kStaleModel, kImplausible, kOutOfLimits, kTime, kMoving, kNoLease, kNotCommissioned
};
struct AnswerEvent { Tag tag; Answer answer = Answer::kAccepted; const char* text = ""; };

enum class GoalState : std::uint8_t { kMoving, kArrived, kStopped, kReplaced };
struct GoalEvent {
  std::uint64_t goal = 0;
  GoalState state = GoalState::kMoving;
  double position_error_m = 0.0, orientation_error_rad = 0.0;
  std::uint64_t model_revision = 0;
  Time time;
  JointVector q_reading_rad;
  const char* text = "";
};

enum class LookOutcome : std::uint8_t { kFiltered, kNoJoints, kMoving, kImplausible };
struct FilterEvent {
  LookOutcome look = LookOutcome::kFiltered;
  FusionReport report;
  std::uint64_t model_revision = 0;
  Vector3 delta_t_m = Vector3::Zero(), delta_theta_rad = Vector3::Zero();  ///< since the recalibration began, (5.2)
  JointVector delta_beta_rad, q_reading_rad;
  Vector6 hand_sigma = Vector6::Zero();
  Time capture_time;
};

enum class ModelSource : std::uint8_t { kNominal, kLoaded, kCalibration, kFilter };
struct ModelEvent {
  LearnedModel model;
  StateMatrix P;
  ModelSource source = ModelSource::kNominal;
  Time time;
};

struct FaultEvent { Fault fault; Time time; };
/// A stop that needs no clearing: who, why, with which evidence.
struct StopEvent { Fault cause; Time time; };

using Event = std::variant<AnswerEvent, GoalEvent, FilterEvent, ModelEvent, FaultEvent, StopEvent>;

/// The newest state, overwritten every cycle.
struct ArmSnapshot {
  Time time;                            ///< sampling instant of the joints
  Mode mode = Mode::kBoot;
  bool has_positions = false, is_still = false, hand_is_moving = false;
  JointVector q_reading_rad, speed_rad_s, q_command_rad, torque_Nm;
  double hand_closure = 0.0, hand_command = 0.0, hand_effort_permille = 0.0;
  std::array<std::uint16_t, kMaxJoints> stiffness_permille{};
  LearnedModel model;
  std::uint64_t goal = 0;
  Fault fault;
};

/// Both directions. Whoever writes a slot learns which unread value it replaced.
struct Mailboxes {
  StickyFlag stop, model_not_saved;
  Slot<Lease> lease;
  Slot<ModeOrder> mode;
  Slot<Goal> goal;
  Slot<HandOrder> hand;
  Slot<StiffnessOrder> stiffness;
  Slot<RecalibrationOrder> recalibration;
  Slot<Proposal> proposal;
  Ring<Look, kMaxLooks> looks;

  Slot<ArmSnapshot> state;
  Slot<SelfCheck> self_check;
  Ring<Event, 128> events;
};

}  // namespace armsight::arm
