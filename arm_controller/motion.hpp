// How the joints get to a goal: set-points inside all limits (JointServo; for pose goals the last piece led by the pose
// servo on the corrected model), and a slow trim that takes away what the drives leave between them and the encoders.
// Every set-point comes out of the one JointServo, the trim's too.
//
//   kTravel ─at posture─► kApproach (pose goals) ─no speed left─► kSettle ─still─► kTrim ─trimmed, still─► arrived
//
// A pose goal given in the camera is mapped to the base by the model in force, and mapped again when that changes on
// the way; one given in the base, and a joint goal (real angles), keep their meaning.
#pragma once

#include <optional>

#include "arm_controller/commissioning.hpp"
#include "arm_controller/messages.hpp"
#include "arm_controller/stillness.hpp"
#include "protocol/config.hpp"
#include "shared/collision.hpp"
#include "shared/joint_servo.hpp"
#include "shared/pose_servo.hpp"

namespace armsight::arm {

enum class Progress : std::uint8_t { kMoving, kArrived, kGivenUp };

class Motion {
 public:
  explicit Motion(const RobotConfig& robot);

  /// Stands at this reading: reference := actual, no trim.
  void stand_at(const JointVector& q_reading) noexcept;
  void start(const Goal& goal, const LearnedModel& model) noexcept;
  void model_changed(const LearnedModel& model) noexcept;
  Progress step_to_goal(const LearnedModel& model, const StillnessWatch& measured) noexcept;
  /// To a stop, or to where yield_to says.
  void step_to_rest() noexcept;
  /// From now on step_to_rest() leads back to this reading: an arm that met something shall not go on pressing.
  void yield_to(const JointVector& q_reading) noexcept { yield_rad_ = q_reading + trim_; }

  /// The nearest place on the way to a stop begun now, where it is nearer than the margin and nearer than the arm is
  /// already; else nothing. At most nine looks, mostly none.
  std::optional<Clearance> too_near_ahead(const LearnedModel& model) noexcept;
  /// Undoes the last step_to_goal()'s set-point: a stop from there was found free.
  void step_back() noexcept { servo_ = before_; }

  const Commissioning& commissioning() const noexcept { return commissioning_; }
  /// Of readings, before beta; of a joint that is not commissioned: around where it stood when power came on.
  const JointLimits& limits() const noexcept { return limits_; }
  /// Where the joints are led to now, real angles.
  JointVector standing_rad(const JointVector& beta) const noexcept { return servo_.setpoint().q_rad - trim_ + beta; }
  bool is_at_rest() const noexcept { return servo_.is_at_rest() && !yield_rad_; }
  /// What goes to the drives. Inside the limits, or no farther outside than where the arm stood at power-on.
  const JointVector& command_rad() const noexcept { return servo_.setpoint().q_rad; }
  /// Of the model's hand pose at a reading against the goal: metres, radians.
  void errors_at(const JointVector& q_reading, const LearnedModel& model, double& position_m,
                 double& orientation_rad) const noexcept;

  /// Limits of readings so that both q and q + beta stay inside.
  static void reading_limits(const JointLimits& limits, const JointVector& beta, JointVector& min_rad,
                             JointVector& max_rad) noexcept;

 private:
  enum class Phase : std::uint8_t { kTravel, kApproach, kSettle, kTrim };
  void enter(Phase phase) noexcept;
  void take_model(const LearnedModel& model) noexcept;
  void step_travel() noexcept;
  void step_approach(const LearnedModel& model) noexcept;
  Progress step_settle(const StillnessWatch& measured) noexcept;
  Progress step_trim(const LearnedModel& model, const StillnessWatch& measured) noexcept;
  bool is_within_tolerance(const LearnedModel& model, const JointVector& q_reading) const noexcept;
  /// No stop begun now leads from there, so far from everything, to the margin.
  bool is_free_of(const JointVector& q_real, double distance_m, const LearnedModel& model) const noexcept;

  SerialChain chain_;
  JointLimits file_limits_, limits_;
  Commissioning commissioning_;
  double period_s_, goal_tolerance_rad_;
  JointServo servo_;
  JointServo before_;            ///< the last step to the goal
  CollisionModel collision_;
  JointVector levers_m_;
  PoseServoOptions pose_options_;
  std::optional<JointVector> yield_rad_;
  JointVector trim_;             ///< command − the reading that it is to bring about

  Goal goal_;
  JointVector target_reading_, wanted_reading_;
  Pose T_B_G_;                ///< as asked for
  Pose T_B_reachable_;        ///< same place, the nearest orientation that the joints allow
  Pose T_C_G_, T_C_reachable_;
  Phase phase_ = Phase::kTravel;
  double phase_s_ = 0.0;
  JointVector seen_rad_;      ///< where too_near_ahead() looked last, real
  Clearance seen_;            ///< and what it saw there
};

}  // namespace armsight::arm
