#include "host/motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/route.hpp"
#include "host/text.hpp"
#include "protocol/convert.hpp"

namespace armsight::host {
namespace {

constexpr Duration kMotionTimeout = std::chrono::seconds(60);  // 3 rad at a tenth of the working speed; slower: longer
constexpr double kSpeedOfTimeout = 0.1;
constexpr Duration kStillTimeout = std::chrono::seconds(5);
constexpr Duration kHandTimeout = std::chrono::seconds(8);
constexpr Duration kGripSettling = std::chrono::milliseconds(300);  // from contact to full force
constexpr Duration kHandStart = std::chrono::milliseconds(250);  // until the fingers must have begun to move
constexpr std::int64_t kGoalValid_ns = 500'000'000;

std::uint64_t next_goal() {
  static std::uint64_t goal = 0;
  return ++goal;
}

// A goal counts only with our own number: the controller may still report an earlier one.
bool has_ended(HostIo& io, std::uint64_t goal) {
  const auto& status = io.arm().goal_status();
  return status && status->goal() == goal && status->state() != wire::GOAL_STATE_MOVING;
}

// No other posture helps an arm in fault: the flow ends, naming it.
void refuse_fault(HostIo& io) {
  if (io.arm().state()->mode() == wire::MODE_FAULT) throw CommandFailed(fault_text(io));
}

// The lease dies with the link: the controller stops the arm and holds it, whatever becomes of this program.
bool wait_under_way(HostIo& io, const std::function<bool()>& is_done, Duration timeout) try {
  return io.wait_until(is_done, timeout);
} catch (const PeerLost& error) {
  throw PeerLost(std::string(error.what()) +
                 "; the motion ends: the arm stops and holds by itself, and moves again only by a new command");
}

// The goal's end names the kind of stop; the report that came with it names code, side and evidence.
std::string end_text(const ArmLink& arm, const wire::GoalStatus& status, std::int64_t begun_arm_ns) {
  const auto& stop = arm.stop_report();
  const bool is_told = status.state() == wire::GOAL_STATE_STOPPED && stop && stop->arm_time_ns() >= begun_arm_ns;
  const std::string text = is_told ? to_text(*stop) : status.text();
  return to_text(status.state()) + (text.empty() ? "" : ": " + text);
}

MotionResult follow(HostIo& io, std::uint64_t goal, wire::Envelope message, double speed_scale,
                    const std::function<bool()>& is_over) {
  MotionResult result;
  const std::int64_t begun_arm_ns = io.arm().state()->arm_time_ns();
  const CommandOutcome outcome = io.command(std::move(message));
  if (!outcome.is_accepted) {
    refuse_fault(io);
    result.why = "refused: " + outcome.text;
    return result;
  }
  bool was_cut_short = false;
  const auto is_done = [&] { return has_ended(io, goal) || (was_cut_short = is_over && is_over()); };
  const double timeout_s = to_seconds(kMotionTimeout) * std::max(1.0, kSpeedOfTimeout / speed_scale);
  if (!wait_under_way(io, is_done, seconds_to_duration(timeout_s))) {
    result.why = "not there after " + fixed(timeout_s, 0) + " s";
    return result;
  }
  if (was_cut_short) {
    result.why = "cut short";
    return result;
  }
  result.status = *io.arm().goal_status();
  if (result.status.state() != wire::GOAL_STATE_ARRIVED) {
    refuse_fault(io);
    result.why = end_text(io.arm(), result.status, begun_arm_ns);
    return result;
  }
  result.has_arrived = io.wait_until([&] { return io.arm().state()->is_still(); }, kStillTimeout);
  if (!result.has_arrived) result.why = "arrived but not still after 5 s";
  return result;
}

}  // namespace

JointVector to_joint_vector(const google::protobuf::RepeatedField<double>& values) {
  JointVector q(std::min(values.size(), kMaxJoints));
  for (int i = 0; i < static_cast<int>(q.size()); ++i) q[i] = values[i];
  return q;
}

JointVector reading_now(HostIo& io) {
  const JointVector q = to_joint_vector(io.arm().state()->q_reading_rad());
  if (q.size() == 0)
    throw CommandFailed(std::string("arm controller: its joints do not report, mode ") +
                        to_text(io.arm().state()->mode()));
  if (q.size() != io.robot().arm.joint_count()) throw PeerLost("arm controller: state with another number of joints");
  return q;
}

JointVector real_now(HostIo& io) { return reading_now(io) + model_in_force(io).beta; }

LearnedModel model_in_force(HostIo& io) {
  const wire::ModelUpdate& update = *io.arm().model();
  LearnedModel model;
  model.revision = update.revision();
  std::optional<Refused> fault = from_wire(update.base_in_camera(), "base_in_camera", model.T_C_B);
  if (!fault) fault = from_wire(update.beta_rad(), "beta_rad", io.robot().arm.joint_count(), model.beta);
  if (fault) throw PeerLost("arm controller: unsound model: " + fault->text);
  return model;
}

namespace {

MotionResult drive_straight(HostIo& io, const JointVector& q_real, const MotionOptions& options) {
  wire::Envelope message;
  wire::JointGoal& goal = *message.mutable_joint_goal();
  goal.set_goal(next_goal());
  to_wire(q_real, goal.mutable_q_real_rad());
  const double speed_scale = options.speed_scale * io.speed_scale();
  goal.set_speed_scale(speed_scale);
  goal.set_valid_for_ns(kGoalValid_ns);
  goal.set_commission_joint(static_cast<std::uint32_t>(options.commission_joint));
  const std::uint64_t number = goal.goal();
  return follow(io, number, std::move(message), speed_scale, options.is_over);
}

}  // namespace

MotionResult drive_to(HostIo& io, const JointVector& q_real, const MotionOptions& options) {
  MotionResult result;
  for (const JointVector& q : find_route(io.robot(), model_in_force(io), real_now(io), q_real)) {
    result = drive_straight(io, q, options);
    if (!result.has_arrived) return result;
  }
  return result;
}

MotionResult stand_still_here(HostIo& io) { return drive_straight(io, real_now(io), {}); }

MotionResult drive_to(HostIo& io, const PoseTarget& target) {
  wire::Envelope message;
  wire::PoseGoal& goal = *message.mutable_pose_goal();
  goal.set_goal(next_goal());
  goal.set_frame(target.frame);
  to_wire(target.T_X_G, goal.mutable_hand_goal());
  goal.set_model_revision(target.model_revision);
  goal.set_position_tolerance_m(target.position_tolerance_m);
  goal.set_orientation_tolerance_rad(target.orientation_tolerance_rad);
  const double speed_scale = target.speed_scale * io.speed_scale();
  goal.set_speed_scale(speed_scale);
  goal.set_valid_for_ns(kGoalValid_ns);
  if (target.q_seed.size() > 0) to_wire(target.q_seed, goal.mutable_q_seed_rad());
  const std::uint64_t number = goal.goal();
  return follow(io, number, std::move(message), speed_scale, {});
}

HandResult move_hand(HostIo& io, double closure, double force_limit_permille) {
  wire::Envelope message;
  message.mutable_hand_command()->set_closure(closure);
  message.mutable_hand_command()->set_force_limit_permille(
      static_cast<std::uint32_t>(std::lround(force_limit_permille)));
  message.mutable_hand_command()->set_speed_scale(io.speed_scale());
  io.demand(std::move(message), "hand");
  io.wait_until([&] { return io.arm().state()->hand_is_moving(); }, kHandStart);
  const double timeout_s = to_seconds(kHandTimeout) / io.speed_scale();
  if (!io.wait_until([&] { return !io.arm().state()->hand_is_moving(); }, seconds_to_duration(timeout_s))) {
    throw CommandFailed("hand: still moving after " + fixed(timeout_s, 0) + " s");
  }
  io.wait_until([] { return false; }, kGripSettling);
  return {io.arm().state()->hand_closure(), io.arm().state()->hand_effort_permille()};
}

}  // namespace armsight::host
