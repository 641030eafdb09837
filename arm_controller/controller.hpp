// One step of the arm's mind: joint samples and messages in, joint set-points and answers out. Depends on its arguments
// and its own state, nothing else: noexcept, no heap, lock, log, clock or I/O (style.md §5).
#pragma once

#include <array>

#include "arm_controller/adaptation.hpp"
#include "arm_controller/contact_watch.hpp"
#include "arm_controller/hand.hpp"
#include "arm_controller/joint_history.hpp"
#include "arm_controller/joint_io.hpp"
#include "arm_controller/messages.hpp"
#include "arm_controller/motion.hpp"
#include "arm_controller/stiffness.hpp"
#include "arm_controller/stillness.hpp"

namespace armsight::arm {

struct TickOutput {
  static constexpr std::size_t kMaxEvents = 48;  ///< every kind of message answered, and what follows from it
  JointCommand command;
  ArmSnapshot snapshot;
  std::array<Event, kMaxEvents> events;
  std::size_t event_count = 0;
};

class Controller {
 public:
  Controller(const RobotConfig& robot, const StartModel& start);

  const TickOutput& tick(Time now, const JointSamples& joints, const TickInbox& inbox) noexcept;
  Mode mode() const noexcept { return mode_; }

 private:
  void take_samples(const JointSamples& joints) noexcept;
  void take_faults(Time now, const JointSamples& joints, const TickInbox& inbox) noexcept;
  void take_bus_phase(const JointSamples& joints) noexcept;
  void take_lease(Time now, const TickInbox& inbox) noexcept;
  void take_mode_order(Time now, const ModeOrder& order) noexcept;
  AnswerEvent answer_mode_order(const ModeOrder& order) noexcept;
  void take_goal(const Goal& asked) noexcept;
  AnswerEvent judge_goal(const Goal& goal) const noexcept;
  AnswerEvent judge_commissioning(const Goal& goal) const noexcept;
  Goal commissioning_goal(const Goal& goal) const noexcept;
  void take_stiffness_order(const StiffnessOrder& order) noexcept;
  void take_hand_order(const HandOrder& order) noexcept;
  void take_recalibration(const RecalibrationOrder& order) noexcept;
  void take_proposal(const Proposal& proposal) noexcept;
  void take_look(const Look& look) noexcept;
  void take_inbox(Time now, const TickInbox& inbox) noexcept;
  bool may_act(const Tag& tag, bool is_stopped = false) noexcept;

  void raise(Time now, const Fault& fault) noexcept;
  void apply(ModeEvent event) noexcept;
  void stop(Time now, const Fault& cause) noexcept;
  void end_goal(GoalState state, const char* text) noexcept;
  void watch_contact(Time now, const JointSamples& joints) noexcept;
  void step_motion(Time now) noexcept;
  void step_command(const JointSamples& joints, Time now) noexcept;
  void step_soft_joints(const JointSamples& joints, bool is_driven) noexcept;
  void step_stiffness() noexcept;
  void announce_model() noexcept;
  void fill_snapshot(const JointSamples& joints) noexcept;
  template <typename E>
  void emit(const E& event) noexcept {
    if (output_.event_count < TickOutput::kMaxEvents) output_.events[output_.event_count++] = event;
  }

  ArmModel arm_;
  double period_s_, margin_m_;
  Mode mode_ = Mode::kBoot;
  bool wants_power_ = false, wants_recover_ = false, bus_is_ready_ = false;
  bool asked_off_ = false;        ///< else drives that hold after a quick stop keep holding
  bool announced_start_ = false;
  Fault fault_;
  int late_in_a_row_ = 0;
  std::optional<Lease> lease_;
  Time joints_time_;

  JointHistory history_;
  StillnessWatch watch_;
  Motion motion_;
  ContactWatch contact_;
  SoftJoints soft_;
  Stiffness stiffness_;
  bool feeds_gravity_ = false;    ///< drives that give way under it can be told
  Hand hand_;
  Adaptation adaptation_;
  std::uint64_t goal_ = 0;        ///< under way, or last reached
  bool goal_is_active_ = false;
  TickOutput output_;
};

}  // namespace armsight::arm
