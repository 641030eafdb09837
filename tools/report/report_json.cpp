// report.json. Numbers that the machine's speed decides stand under solve_ms, tick_us_* and keys ending in
// _wall_s only.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/report/report.hpp"

namespace armsight::demo {

namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

template <typename Range, typename Pick>
Json list_of(const Range& range, Pick&& pick) {
  Json out = Json::array();
  for (const auto& element : range) out.push_back(pick(element));
  return out;
}

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& v) {
  Json out = Json::array();
  for (const double x : v) out.push_back(x);
  return out;
}

Json model_json(const LearnedModel& model) {
  const Eigen::Quaterniond quat(model.T_C_B.R);
  return {{"revision", model.revision},
          {"T_C_B", {{"p_m", numbers(model.T_C_B.p)}, {"q_wxyz", {quat.w(), quat.x(), quat.y(), quat.z()}}}},
          {"beta_rad", numbers(model.beta)}};
}

Json calibrate_json(const Report& r) {
  const CalibrateResult& c = r.calibrate;
  const auto used = std::count_if(c.looks.begin(), c.looks.end(), [](const auto& look) { return look.is_used; });
  return {{"looks", used},
          {"looks_taken", c.looks.size()},
          {"attempts", c.attempts},
          {"heldout_rms_mm", r.heldout.rms_mm},
          {"heldout_rms_deg", r.heldout.rms_deg},
          {"heldout_postures", r.heldout.postures},
          {"training_rms_mm", c.training_mm},
          {"training_rms_deg", c.training_deg},
          {"crossvalidation_rms_mm", c.crossvalidation_mm},
          {"crossvalidation_rms_deg", c.crossvalidation_deg},
          {"solve_ms", c.solve_wall_ms},
          {"rank", c.rank},
          {"parameters", c.parameters},
          {"unobservable", c.unobservable},
          {"beta_error_deg", list_of(r.parameters.beta_error_deg, or_null)},
          {"beta_sigma_deg", list_of(c.sigma_beta_deg, or_null)},
          {"camera_error_mm", r.parameters.camera.mm},
          {"camera_error_deg", r.parameters.camera.deg},
          {"camera_sigma_mm", or_null(c.sigma_camera_mm)},
          {"camera_sigma_deg", or_null(c.sigma_camera_deg)},
          {"model", model_json(c.model)}};
}

Json adapt_json(const Report& r) {
  const auto model_mm = [](const CommandedPose& p) { return p.model_error.mm; };
  const auto model_deg = [](const CommandedPose& p) { return p.model_error.deg; };
  const auto reached_mm = [](const CommandedPose& p) { return p.reached_error.mm; };
  const auto reached_deg = [](const CommandedPose& p) { return p.reached_error.deg; };
  return {{"without_filter_mm", list_of(r.without_filter, model_mm)},
          {"with_filter_mm", list_of(r.with_filter, model_mm)},
          {"without_filter_deg", list_of(r.without_filter, model_deg)},
          {"with_filter_deg", list_of(r.with_filter, model_deg)},
          {"without_filter_reached_mm", list_of(r.without_filter, reached_mm)},
          {"with_filter_reached_mm", list_of(r.with_filter, reached_mm)},
          {"without_filter_reached_deg", list_of(r.without_filter, reached_deg)},
          {"with_filter_reached_deg", list_of(r.with_filter, reached_deg)},
          {"after_looks_mm", list_of(r.after_looks, [](const PoseError& e) { return e.mm; })},
          {"after_looks_deg", list_of(r.after_looks, [](const PoseError& e) { return e.deg; })},
          {"looks", list_of(r.adapt.looks,
                            [](const AdaptLook& look) {
                              return Json{{"outcome", look.outcome},
                                          {"nis", look.nis},
                                          {"cost", look.cost},
                                          {"gain_norm", look.gain_norm},
                                          {"iterations", look.iterations},
                                          {"delta_t_m", numbers(look.delta_t_m)},
                                          {"delta_theta_rad", numbers(look.delta_theta_rad)},
                                          {"delta_beta_rad", numbers(look.delta_beta)}};
                            })},
          {"model", model_json(r.adapt.after)}};
}

Json grasp_json(const GraspResult& result, const GraspEvaluation& evaluation) {
  const auto or_null_if_open = [&](double v) { return evaluation.was_closed ? Json(v) : Json(nullptr); };
  return {{"error_mm", or_null_if_open(evaluation.error.mm)},
          {"error_deg", or_null_if_open(evaluation.error.deg)},
          {"success", evaluation.is_success},
          {"verdict", result.verdict},
          {"why", result.why},
          {"verdict_agrees_with_truth", evaluation.does_verdict_agree}};
}

Json duration_json(const DurationRow& row) {
  return {{"name", row.name},           {"count", row.count},   {"p50_us", row.p50_us},
          {"p999_us", row.p999_us},     {"max_us", row.max_us}, {"upper_ns", row.upper_ns},
          {"counts", row.counts}};
}

}  // namespace

std::string to_json(const Report& r) {
  Json programs = Json::object(), phases = Json::array();
  for (const auto& [name, version] : r.versions) programs[name] = {{"version", version}};
  for (const Phase& p : r.phases) {
    phases.push_back({{"name", p.name}, {"simulated_s", p.simulated_s}, {"phase_wall_s", p.wall_s}});
  }
  std::vector<DurationRow> simulated, measured;  // the tick alone depends on the machine in lockstep
  for (const DurationRow& row : r.controller.durations) (row.name == "tick" ? measured : simulated).push_back(row);
  const Json report = {{"seed", r.seed},
                       {"noise", r.noise},
                       {"bus", r.bus},
                       {"pace", r.pace},
                       {"robot", r.robot_name},
                       {"programs", programs},
                       {"calibrate", calibrate_json(r)},
                       {"adapt", adapt_json(r)},
                       {"grasp", {{"without_filter", grasp_json(r.grasp_without, r.without_grasp)},
                                  {"with_filter", grasp_json(r.grasp_with, r.with_grasp)}}},
                       {"controller", {{"rate_hz", r.controller.rate_hz},
                                       {"tick_us_p50", r.controller.tick_us_p50},
                                       {"tick_us_p999", r.controller.tick_us_p999},
                                       {"cycles", r.controller.cycles},
                                       {"missed", r.controller.missed},
                                       {"durations", list_of(simulated, duration_json)},
                                       {"tick_us_histogram", list_of(measured, duration_json)},
                                       {"black_boxes", r.controller.black_boxes}}},
                       {"phases", phases}};
  return report.dump(2) + "\n";
}

}  // namespace armsight::demo
