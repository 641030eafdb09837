#include "host/json_out.hpp"

#include <nlohmann/json.hpp>

#include "host/status.hpp"
#include "host/text.hpp"
#include "protocol/convert.hpp"

namespace armsight::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kIndent = 1;

Json json(const Pose& T) {
  const Eigen::Quaterniond q(T.R);
  return {{"p_m", {T.p.x(), T.p.y(), T.p.z()}}, {"q_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

Json json(const JointVector& q) {
  Json list = Json::array();
  for (const double value : q) list.push_back(value);
  return list;
}

Json json(const google::protobuf::RepeatedField<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

Json json(const wire::Vector3& v) { return {v.x(), v.y(), v.z()}; }

Json json(const LearnedModel& model) {
  return {{"revision", model.revision}, {"T_C_B", json(model.T_C_B)}, {"beta_rad", json(model.beta)}};
}

Json json(const std::optional<Pose>& T) { return T ? json(*T) : Json(nullptr); }

Json json(const PoseErrorRms& rms) { return {{"rms_mm", rms.rms_mm}, {"rms_deg", rms.rms_deg}}; }

Json look_json(const CalibrateLookRecord& look, const LookVerdict& verdict) {
  return {{"q_reading_rad", json(look.q_reading)}, {"arm_time_ns", look.arm_time_ns}, {"used", verdict.used},
          {"reason", verdict.reason}, {"residual_mm", verdict.residual_mm},
          {"residual_deg", verdict.residual_deg}, {"reprojection_px", look.reprojection_px},
          {"image", look.image}};
}

Json sigma_json(const ArmCalibration& calibration) {
  Json beta = Json::array();
  for (const double sigma : calibration.beta_sigma_rad) beta.push_back(degrees(sigma));
  return {{"beta_deg", beta}, {"camera_mm", calibration.camera_sigma_m * 1e3},
          {"camera_deg", degrees(calibration.camera_sigma_rad)}};
}

Json look_json(const AdaptLookRecord& look) {
  const wire::FilterReport& r = look.report;
  return {{"outcome", to_text(r.outcome())}, {"nis", r.nis()}, {"cost", r.cost()},
          {"gain_norm", r.gain_norm()}, {"iterations", r.iterations()}, {"innovation", json(r.innovation())},
          {"q_reading_rad", json(r.q_reading_rad())}, {"delta_t_m", json(r.delta_t_m())},
          {"delta_theta_rad", json(r.delta_theta_rad())}, {"delta_beta_rad", json(r.delta_beta_rad())},
          {"hand_sigma", json(r.hand_sigma())}, {"arm_time_ns", r.arm_capture_time_ns()}, {"model", json(look.model)},
          {"image", look.image}};
}

}  // namespace

std::string to_json(const CalibrateRecord& record) {
  const ArmCalibration& c = record.calibration;
  Json looks = Json::array();
  for (std::size_t i = 0; i < record.looks.size(); ++i) {
    looks.push_back(
        look_json(record.looks[i], i < c.looks.size() ? c.looks[i] : LookVerdict{false, false, "not solved", 0, 0}));
  }
  const Json out{{"accepted", c.accepted}, {"why", c.why}, {"looks", looks}, {"training", json(c.training)},
                 {"heldout", json(c.heldout)}, {"sigma", sigma_json(c)}, {"rank", c.rank}, {"parameters", c.parameters},
                 {"condition", c.condition}, {"unobservable", c.unobservable},
                 {"solve_wall_ms", c.solve_wall_s * 1e3}, {"model", json(record.model)},
                 {"attempts", record.attempts}, {"images", record.images}};
  return out.dump(kIndent) + "\n";
}

std::string to_json(const AdaptRecord& record) {
  Json looks = Json::array();
  for (const AdaptLookRecord& look : record.looks) looks.push_back(look_json(look));
  const Json out{{"model_before", json(record.before)}, {"looks", looks}, {"attempts", record.attempts},
                 {"model_after", json(record.after)}};
  return out.dump(kIndent) + "\n";
}

std::string to_json(const MoveRecord& record) {
  Json out;
  if (record.T_B_G) out["T_B_G"] = json(*record.T_B_G);
  else out["q_goal_real_rad"] = json(record.q_goal_real);
  out["state"] = record.state;
  out["arm_time_ns"] = record.status.arm_time_ns();
  out["q_reading_rad"] = json(record.status.q_reading_rad());
  out["model"] = json(record.model);
  out["position_error_m"] = record.status.position_error_m();
  out["orientation_error_rad"] = record.status.orientation_error_rad();
  return out.dump(kIndent) + "\n";
}

std::string to_json(const GraspRecord& record) {
  const Json out{{"object", record.object},
                 {"candidate", record.candidate},
                 {"T_C_O", json(record.T_C_O)},
                 {"T_O_G", json(record.T_O_G)},
                 {"T_B_G", json(record.T_B_G)},
                 {"model", json(record.model)},
                 {"status", record.status},
                 {"arm_time_ns", record.arm_time_ns},
                 {"q_reading_rad", json(record.q_reading)},
                 {"verdict", record.verdict},
                 {"why", record.why},
                 {"then", record.then},
                 {"hand_closure", record.hand_closure},
                 {"hand_effort_permille", record.hand_effort_permille},
                 {"images", record.images},
                 {"image_closed", record.image_closed}};
  return out.dump(kIndent) + "\n";
}

std::string to_json(const wire::ControllerStatistics& s) {
  Json rows = Json::array();
  for (const wire::DurationHistogram& row : s.durations())
    rows.push_back({{"name", duration_name(row)}, {"count", row.count()}, {"p50_us", row.p50_us()},
                    {"p999_us", row.p999_us()}, {"max_us", row.max_us()},
                    {"upper_ns", std::vector<std::uint64_t>(row.upper_ns().begin(), row.upper_ns().end())},
                    {"counts", std::vector<std::uint64_t>(row.counts().begin(), row.counts().end())}});
  const Json out{{"rate_hz", s.rate_hz()}, {"cycles", s.cycles()}, {"missed", s.missed()},
                 {"tick_us_p50", s.tick_us_p50()}, {"tick_us_p999", s.tick_us_p999()},
                 {"durations", rows}};
  return out.dump(kIndent) + "\n";
}

}  // namespace armsight::host
