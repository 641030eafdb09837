#include "tools/report/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "shared/hand_eye.hpp"

namespace armsight::demo {

namespace {

constexpr double kSuccess_mm = 10.0, kSuccess_deg = 5.0;  // specification E4
constexpr std::int64_t kClosingBound_ns = 10'000'000'000;

Pose turn_about_z(double angle) { return {so3_exp(Vector3(0, 0, angle)), Vector3::Zero()}; }

bool is_visible(const Pose& T_C_M, const Experiment& e) {
  const Vector3& p = T_C_M.p;
  if (p.z() < e.min_depth_m || p.z() > e.max_depth_m) return false;
  if (std::abs(p.x()) > e.view_x * p.z() || std::abs(p.y()) > e.view_y * p.z()) return false;
  const double cosine_of_tilt = -T_C_M.R.col(2).dot(p.normalized());  // z_M comes out of the marker
  return cosine_of_tilt > std::cos(e.max_tilt_rad);
}

bool is_far_from_all(const JointVector& q, const std::vector<CalibrationLook>& looks, double distance_rad) {
  return std::ranges::all_of(looks, [&](const CalibrationLook& look) {
    return (q - look.q_reading).cwiseAbs().maxCoeff() > distance_rad;
  });
}

/// Uniform in [0, 1) from the top 53 bits: the same on every standard library.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace

PoseError error_between(const Pose& a, const Pose& b) {
  return {1e3 * (a.p - b.p).norm(), rotation_angle(a.R, b.R) / kDegree};
}

double median(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("median of no values");
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

PoseError median_model_error(const std::vector<CommandedPose>& poses) {
  std::vector<double> mm, deg;
  for (const CommandedPose& pose : poses) {
    mm.push_back(pose.model_error.mm);
    deg.push_back(pose.model_error.deg);
  }
  return {median(mm), median(deg)};
}

const TruthRow& row_at(const Truth& truth, std::int64_t arm_time_ns) {
  const auto after = std::ranges::lower_bound(truth.rows, arm_time_ns, {}, &TruthRow::arm_time_ns);
  const TruthRow* nearest = nullptr;
  if (after != truth.rows.end()) nearest = &*after;
  if (after != truth.rows.begin()) {
    const TruthRow& before = *std::prev(after);
    if (nearest == nullptr || arm_time_ns - before.arm_time_ns < nearest->arm_time_ns - arm_time_ns) nearest = &before;
  }
  constexpr std::int64_t kHalfPeriod_ns = 2'100'000;
  if (nearest == nullptr || std::abs(nearest->arm_time_ns - arm_time_ns) > kHalfPeriod_ns) {
    throw std::runtime_error("truth.csv: no row at arm time " + std::to_string(arm_time_ns) + " ns");
  }
  return *nearest;
}

Pose true_T_C_H(const Truth& truth, std::int64_t arm_time_ns) {
  const bool is_after = arm_time_ns >= truth.drift_arm_time_ns;
  return (is_after ? truth.after : truth.before).T_C_B * row_at(truth, arm_time_ns).T_B_H;
}

HeldOut evaluate_heldout(const Truth& truth, const LearnedModel& model, const std::vector<CalibrationLook>& looks,
                         const RobotConfig& robot, const Experiment& experiment) {
  std::mt19937_64 random(experiment.heldout_seed);
  const JointLimits& limits = robot.arm.limits;
  HeldOut result;
  double sum_mm2 = 0, sum_deg2 = 0;
  constexpr int kMostDraws = 2'000'000;
  for (int draw = 0; draw < kMostDraws && result.postures < experiment.heldout_postures; ++draw) {
    JointVector q_real(robot.arm.joint_count());
    for (int i = 0; i < q_real.size(); ++i) {
      q_real(i) = limits.min_rad(i) + uniform(random) * (limits.max_rad(i) - limits.min_rad(i));
    }
    const Pose T_C_H = truth.before.T_C_B * forward_kinematics(truth.chain, q_real);
    const JointVector q = q_real - truth.before.beta;
    if (!is_visible(T_C_H * robot.arm.T_H_M, experiment)) continue;
    if (!is_far_from_all(q, looks, experiment.heldout_distance_rad)) continue;
    const PoseError e = error_between(predict_T_C_H(robot.arm.chain, model.T_C_B, model.beta, q), T_C_H);
    sum_mm2 += e.mm * e.mm;
    sum_deg2 += e.deg * e.deg;
    ++result.postures;
  }
  if (result.postures == 0)
    throw std::runtime_error("no visible posture found to hold out: is the camera's truth right?");
  result.rms_mm = std::sqrt(sum_mm2 / result.postures);
  result.rms_deg = std::sqrt(sum_deg2 / result.postures);
  return result;
}

GaugeAligned evaluate_parameters(const LearnedModel& truth, const CalibrateResult& result, const SerialChain& chain) {
  GaugeAligned aligned;
  const double s = truth.beta(0) - result.model.beta(0);
  const Pose T_C_B = truth.T_C_B * chain.T_B_0 * turn_about_z(s) * chain.T_B_0.inverse();
  aligned.camera = error_between(result.model.T_C_B, T_C_B);
  for (int i = 0; i < truth.beta.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool is_observable = at < result.sigma_beta_deg.size() && result.sigma_beta_deg[at].has_value();
    if (is_observable) aligned.beta_error_deg.emplace_back((result.model.beta(i) - truth.beta(i)) / kDegree);
    else aligned.beta_error_deg.emplace_back(std::nullopt);
  }
  return aligned;
}

CommandedPose evaluate_move(const Truth& truth, const MoveResult& move, const SerialChain& nominal) {
  CommandedPose pose;
  pose.T_C_G = move.model.T_C_B * forward_kinematics(nominal, move.q_goal_real);
  pose.T_C_H = true_T_C_H(truth, move.arm_time_ns);
  pose.model_error =
      error_between(predict_T_C_H(nominal, move.model.T_C_B, move.model.beta, move.q_reading), pose.T_C_H);
  pose.reached_error = error_between(pose.T_C_H, pose.T_C_G);
  return pose;
}

PoseError median_error(const Truth& truth, const std::vector<MoveResult>& moves, const LearnedModel& model,
                       const SerialChain& nominal) {
  std::vector<double> mm, deg;
  for (const MoveResult& move : moves) {
    const Pose T_C_H = predict_T_C_H(nominal, model.T_C_B, model.beta, move.q_reading);
    const PoseError e = error_between(T_C_H, true_T_C_H(truth, move.arm_time_ns));
    mm.push_back(e.mm);
    deg.push_back(e.deg);
  }
  return {median(mm), median(deg)};
}

GraspEvaluation evaluate_grasp(const Truth& truth, const GraspResult& grasp) {
  GraspEvaluation result;
  const auto distance_ns = [&](const TruthGrasp& g) { return std::abs(g.arm_time_ns - grasp.arm_time_ns); };
  const auto attempt = std::ranges::min_element(truth.grasps, {}, distance_ns);
  result.was_closed =
      grasp.verdict != "refused" && attempt != truth.grasps.end() && distance_ns(*attempt) < kClosingBound_ns;
  result.does_verdict_agree = (grasp.verdict == "grasped") == (result.was_closed && attempt->is_held);
  if (!result.was_closed) return result;
  result.error = {1e3 * attempt->error_m, attempt->error_rad / kDegree};
  result.is_success = attempt->is_held && result.error.mm <= kSuccess_mm && result.error.deg <= kSuccess_deg;

  // The object is round: every yaw about z_O is as good. The nearest one has the hand's axis where the hand is.
  const Pose T_O_H = truth.T_B_O.inverse() * row_at(truth, grasp.arm_time_ns).T_B_H;
  const double yaw = std::atan2(T_O_H.p.y(), T_O_H.p.x()) - std::atan2(grasp.T_O_G.p.y(), grasp.T_O_G.p.x());
  const Pose T_G_O = (turn_about_z(yaw) * grasp.T_O_G).inverse();
  const Pose T_C_O = truth.after.T_C_B * truth.T_B_O;
  result.T_G_reached = T_G_O * T_O_H;
  result.T_G_computed = T_G_O * (T_C_O.inverse() * grasp.T_C_O) * grasp.T_O_G;
  return result;
}

}  // namespace armsight::demo
