// Results and truth → the figures of the report.
#include "shared/hand_eye.hpp"
#include "tools/report/report.hpp"

namespace armsight::demo {

namespace {

/// Shoulder, joints and hand as points in the camera: what fig. 8.4 draws. Coinciding points are left out.
std::vector<Vector3> arm_points(const Pose& T_C_B, const SerialChain& chain, const JointVector& q) {
  Pose T = T_C_B * chain.T_B_0;
  std::vector<Vector3> points{T.p};
  for (int i = 0; i < chain.joint_count; ++i) {
    T = T * Pose{so3_exp(Vector3(0, 0, q(i))), Vector3::Zero()} * chain.T_after[static_cast<std::size_t>(i)];
    if ((T.p - points.back()).norm() > 1e-6) points.push_back(T.p);
  }
  return points;
}

std::vector<LearnedModel> models_after_looks(const AdaptResult& adapt) {
  std::vector<LearnedModel> models{adapt.before};
  for (const AdaptLook& look : adapt.looks) models.push_back(look.model);
  return models;
}

}  // namespace

void evaluate(Report& report, const Truth& truth, const std::vector<MoveResult>& moves_without,
              const std::vector<MoveResult>& moves_with, const RobotConfig& robot, const Experiment& experiment) {
  const SerialChain& chain = robot.arm.chain;
  report.heldout = evaluate_heldout(truth, report.calibrate.model, report.calibrate.looks, robot, experiment);
  report.parameters = evaluate_parameters(truth.before, report.calibrate, chain);

  for (const MoveResult& move : moves_without) report.without_filter.push_back(evaluate_move(truth, move, chain));
  for (const MoveResult& move : moves_with) {
    report.with_filter.push_back(evaluate_move(truth, move, chain));
    report.arm_in_camera.push_back(arm_points(truth.after.T_C_B, truth.chain, row_at(truth, move.arm_time_ns).q_true));
  }
  for (const LearnedModel& model : models_after_looks(report.adapt)) {
    report.after_looks.push_back(median_error(truth, moves_with, model, chain));
  }
  for (const MoveResult& move : moves_with) {
    std::vector<double> errors_mm;
    for (const LearnedModel& model : models_after_looks(report.adapt)) {
      errors_mm.push_back(median_error(truth, {move}, model, chain).mm);
    }
    report.after_looks_mm_each.push_back(errors_mm);
  }
  report.without_grasp = evaluate_grasp(truth, report.grasp_without);
  report.with_grasp = evaluate_grasp(truth, report.grasp_with);
}

}  // namespace armsight::demo
