#include "arm_controller/link_reports.hpp"

#include "protocol/convert.hpp"

namespace armsight::arm {
namespace {

wire::FusionOutcome outcome(const FilterEvent& event) {
  if (event.look == LookOutcome::kNoJoints) return wire::FUSION_OUTCOME_NO_JOINTS;
  if (event.look == LookOutcome::kMoving) return wire::FUSION_OUTCOME_MOVING;
  if (event.look == LookOutcome::kImplausible) return wire::FUSION_OUTCOME_IMPLAUSIBLE;
  switch (event.report.outcome) {
    case FusionOutcome::kFused: return wire::FUSION_OUTCOME_FUSED;
    case FusionOutcome::kFusedSecondSolution: return wire::FUSION_OUTCOME_FUSED_SECOND_SOLUTION;
    case FusionOutcome::kRejectedByGate: return wire::FUSION_OUTCOME_REJECTED_BY_GATE;
    case FusionOutcome::kIllConditioned: return wire::FUSION_OUTCOME_ILL_CONDITIONED;
    case FusionOutcome::kNotFinite: break;
  }
  return wire::FUSION_OUTCOME_NOT_FINITE;
}

const char* source_text(ModelSource source) {
  switch (source) {
    case ModelSource::kNominal: return "nominal";
    case ModelSource::kLoaded: return "loaded";
    case ModelSource::kCalibration: return "calibration";
    case ModelSource::kFilter: break;
  }
  return "filter";
}

void put(const Vector3& v, wire::Vector3* out) {
  out->set_x(v.x());
  out->set_y(v.y());
  out->set_z(v.z());
}

void add_duration(wire::MeasuredDuration what, unsigned node, const Histogram& histogram, wire::ControllerStatistics& out) {
  const std::uint64_t count = histogram.count();
  if (count == 0) return;
  wire::DurationHistogram& row = *out.add_durations();
  row.set_what(what);
  row.set_node(node);
  row.set_count(count);
  row.set_p50_us(1e-3 * static_cast<double>(histogram.quantile_ns(0.5)));
  row.set_p999_us(1e-3 * static_cast<double>(histogram.quantile_ns(0.999)));
  row.set_max_us(1e-3 * static_cast<double>(histogram.longest_ns()));
  histogram.for_each([&](std::int64_t upper_ns, std::uint64_t in_bucket) {
    row.add_upper_ns(static_cast<std::uint64_t>(upper_ns));
    row.add_counts(in_bucket);
  });
}

}  // namespace

void add_durations(const LoopStatistics& statistics, const RobotConfig& robot, wire::ControllerStatistics& out) {
  add_duration(wire::MEASURED_DURATION_WAKE_UP, 0, statistics.wake_up, out);
  add_duration(wire::MEASURED_DURATION_TICK, 0, statistics.tick, out);
  add_duration(wire::MEASURED_DURATION_SYNC_PERIOD, 0, statistics.sync_period, out);
  const auto joints = static_cast<std::size_t>(robot.arm.joint_count());
  for (std::size_t i = 0; i <= joints; ++i)
    add_duration(wire::MEASURED_DURATION_TPDO1, i < joints ? robot.drives[i].node : robot.hand.node, statistics.tpdo1[i],
                 out);
}

wire::Mode to_wire(Mode mode) { return static_cast<wire::Mode>(static_cast<int>(mode) + 1); }
static_assert(static_cast<int>(Mode::kRecovering) + 1 == static_cast<int>(wire::MODE_RECOVERING));
static_assert(static_cast<int>(Mode::kServo) + 1 == static_cast<int>(wire::MODE_SERVO));

wire::RefusalReason to_wire(Answer answer) {
  switch (answer) {
    case Answer::kAccepted: break;
    case Answer::kWrongState: return wire::REFUSAL_REASON_WRONG_STATE;
    case Answer::kStaleModel: return wire::REFUSAL_REASON_STALE_MODEL;
    case Answer::kImplausible: return wire::REFUSAL_REASON_IMPLAUSIBLE;
    case Answer::kOutOfLimits: return wire::REFUSAL_REASON_OUT_OF_LIMITS;
    case Answer::kTime: return wire::REFUSAL_REASON_TIME;
    case Answer::kMoving: return wire::REFUSAL_REASON_MOVING;
    case Answer::kNoLease: return wire::REFUSAL_REASON_NO_LEASE;
    case Answer::kNotCommissioned: return wire::REFUSAL_REASON_NOT_COMMISSIONED;
  }
  return wire::REFUSAL_REASON_UNSPECIFIED;
}

void to_wire(const ArmSnapshot& state, wire::ArmState& out) {
  out.set_arm_time_ns(to_ns(state.time));
  out.set_mode(to_wire(state.mode));
  if (state.has_positions) {
    armsight::to_wire(state.q_reading_rad, out.mutable_q_reading_rad());
    armsight::to_wire(state.speed_rad_s, out.mutable_speed_rad_s());
    armsight::to_wire(state.q_command_rad, out.mutable_q_command_rad());
    armsight::to_wire(state.torque_Nm, out.mutable_torque_nm());
    for (Eigen::Index i = 0; i < state.q_reading_rad.size(); ++i)
      out.add_stiffness_permille(state.stiffness_permille[static_cast<std::size_t>(i)]);
  }
  out.set_hand_closure(state.hand_closure);
  out.set_hand_effort_permille(state.hand_effort_permille);
  out.set_hand_is_moving(state.hand_is_moving);
  out.set_is_still(state.is_still);
  out.set_model_revision(state.model.revision);
  out.set_goal(state.goal);
  out.set_fault_code(static_cast<std::uint32_t>(state.fault.code));
}

void to_wire(const GoalEvent& event, wire::GoalStatus& out) {
  out.set_goal(event.goal);
  out.set_state(static_cast<wire::GoalState>(static_cast<int>(event.state) + 1));
  out.set_position_error_m(event.position_error_m);
  out.set_orientation_error_rad(event.orientation_error_rad);
  out.set_model_revision(event.model_revision);
  out.set_arm_time_ns(to_ns(event.time));
  armsight::to_wire(event.q_reading_rad, out.mutable_q_reading_rad());
  out.set_text(event.text);
}
static_assert(static_cast<int>(GoalState::kReplaced) + 1 == static_cast<int>(wire::GOAL_STATE_REPLACED));

void to_wire(const FilterEvent& event, wire::FilterReport& out) {
  out.set_outcome(outcome(event));
  for (int i = 0; i < 6; ++i) out.add_innovation(event.report.innovation[i]);
  out.set_nis(event.report.nis);
  out.set_cost(event.report.cost);
  out.set_gain_norm(event.report.gain_norm);
  out.set_iterations(static_cast<std::uint32_t>(event.report.iterations));
  out.set_model_revision(event.model_revision);
  put(event.delta_t_m, out.mutable_delta_t_m());
  put(event.delta_theta_rad, out.mutable_delta_theta_rad());
  armsight::to_wire(event.delta_beta_rad, out.mutable_delta_beta_rad());
  out.set_arm_capture_time_ns(to_ns(event.capture_time));
  armsight::to_wire(event.q_reading_rad, out.mutable_q_reading_rad());
  for (int i = 0; i < 6; ++i) out.add_hand_sigma(event.hand_sigma[i]);
}

void to_wire(const ModelEvent& event, wire::ModelUpdate& out) {
  out.set_revision(event.model.revision);
  armsight::to_wire(event.model.T_C_B, out.mutable_base_in_camera());
  armsight::to_wire(event.model.beta, out.mutable_beta_rad());
  armsight::to_wire(event.P, out.mutable_covariance());
  out.set_source(source_text(event.source));
  out.set_arm_time_ns(to_ns(event.time));
}

void to_wire(const FaultEvent& event, wire::FaultReport& out) {
  out.set_code(static_cast<std::uint32_t>(event.fault.code));
  out.set_text(fault_text(event.fault));
  out.set_side(fault_side(event.fault.code));
  out.set_arm_time_ns(to_ns(event.time));
}

void to_wire(const StopEvent& event, const CollisionConfig& names, wire::StopReport& out) {
  out.set_code(static_cast<std::uint32_t>(event.cause.code));
  if (event.cause.code == FaultCode::kTooNear)
    out.set_text(std::string(stop_text(event.cause.code)) + ": a stop any later would end where " +
                 to_text(names, clearance_of(event.cause)));
  else
    out.set_text(fault_text(event.cause));
  out.set_side(fault_side(event.cause.code));
  out.set_arm_time_ns(to_ns(event.time));
}

}  // namespace armsight::arm
