#include "tools/report/results.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

namespace armsight::demo {

namespace {

using nlohmann::json;

JointVector joints_from(const json& j) {
  if (!j.is_array() || j.empty() || j.size() > kMaxJoints)
    throw std::runtime_error("must be a list of 1 to 8 joint angles");
  JointVector q(static_cast<Eigen::Index>(j.size()));
  for (std::size_t i = 0; i < j.size(); ++i) q(static_cast<Eigen::Index>(i)) = j[i].get<double>();
  return q;
}

template <typename Vector>
Vector vector_from(const json& j) {
  Vector v;
  if (!j.is_array() || static_cast<Eigen::Index>(j.size()) != v.size()) {
    throw std::runtime_error("must be a list of " + std::to_string(v.size()) + " numbers");
  }
  for (std::size_t i = 0; i < j.size(); ++i) v(static_cast<Eigen::Index>(i)) = j[i].get<double>();
  return v;
}

Pose pose_from(const json& j) {
  const auto wxyz = vector_from<Eigen::Vector4d>(j.at("q_wxyz"));
  const Eigen::Quaterniond quat(wxyz(0), wxyz(1), wxyz(2), wxyz(3));
  if (std::abs(quat.norm() - 1.0) > 1e-3) throw std::runtime_error("q_wxyz: must have unit length");
  return {quat.normalized().toRotationMatrix(), vector_from<Vector3>(j.at("p_m"))};
}

LearnedModel model_from(const json& j) {
  return {j.value("revision", std::uint64_t{0}), pose_from(j.at("T_C_B")), joints_from(j.at("beta_rad"))};
}

std::optional<double> number_or_null(const json& j) {
  return j.is_number() ? std::optional<double>(j.get<double>()) : std::nullopt;
}

std::vector<std::string> texts_from(const json& j) { return j.get<std::vector<std::string>>(); }

json parse(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot be read");
  return json::parse(in);
}

/// Runs a reader; whatever is wrong is told with the file's name.
template <typename Read>
auto read_result(const std::filesystem::path& file, Read&& reader) {
  try {
    return reader(parse(file));
  } catch (const std::exception& e) {
    throw std::runtime_error(file.filename().string() + ": " + e.what());
  }
}

CalibrationLook calibration_look(const json& j) {
  return {joints_from(j.at("q_reading_rad")),
          j.at("arm_time_ns"),
          j.at("used"),
          j.value("reason", ""),
          j.value("image", ""),
          j.value("residual_mm", 0.0),
          j.value("residual_deg", 0.0),
          j.value("reprojection_px", 0.0)};
}

AdaptLook adapt_look(const json& j) {
  AdaptLook look;
  look.outcome = j.at("outcome");
  look.image = j.value("image", "");
  look.nis = j.at("nis");
  look.cost = j.at("cost");
  look.gain_norm = j.at("gain_norm");
  look.iterations = j.at("iterations");
  look.innovation = vector_from<Vector6>(j.at("innovation"));
  look.q_reading = joints_from(j.at("q_reading_rad"));
  look.delta_beta = joints_from(j.at("delta_beta_rad"));
  look.delta_t_m = vector_from<Vector3>(j.at("delta_t_m"));
  look.delta_theta_rad = vector_from<Vector3>(j.at("delta_theta_rad"));
  look.arm_time_ns = j.at("arm_time_ns");
  look.model = model_from(j.at("model"));
  return look;
}

SerialChain chain_from(const json& j) {
  SerialChain chain;
  chain.T_B_0 = pose_from(j.at("T_B_0"));
  const json& after = j.at("T_after");
  if (after.empty() || after.size() > kMaxJoints) throw std::runtime_error("arm.T_after: must have 1 to 8 poses");
  chain.joint_count = static_cast<int>(after.size());
  for (std::size_t i = 0; i < after.size(); ++i) chain.T_after[i] = pose_from(after[i]);
  return chain;
}

std::vector<TruthRow> load_rows(const std::filesystem::path& file, int joints) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.filename().string() + ": cannot be read");
  std::vector<TruthRow> rows;
  std::string line;
  std::getline(in, line);  // header
  for (int number = 2; std::getline(in, line); ++number) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    TruthRow row{0, JointVector(joints), JointVector(joints), {}};
    Eigen::Quaterniond quat;
    fields >> row.arm_time_ns;
    for (int i = 0; i < joints; ++i) fields >> row.q_true(i);
    for (int i = 0; i < joints; ++i) fields >> row.q_reading(i);
    fields >> row.T_B_H.p.x() >> row.T_B_H.p.y() >> row.T_B_H.p.z() >> quat.w() >> quat.x() >> quat.y() >> quat.z();
    if (!fields)
      throw std::runtime_error(file.filename().string() + ":" + std::to_string(number) + ": too few numbers");
    row.T_B_H.R = quat.normalized().toRotationMatrix();
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

CalibrateResult load_calibrate(const std::filesystem::path& file) {
  return read_result(file, [](const json& j) {
    CalibrateResult r;
    for (const json& look : j.at("looks")) r.looks.push_back(calibration_look(look));
    r.training_mm = j.at("training").at("rms_mm");
    r.training_deg = j.at("training").at("rms_deg");
    r.crossvalidation_mm = j.at("heldout").at("rms_mm");
    r.crossvalidation_deg = j.at("heldout").at("rms_deg");
    for (const json& s : j.at("sigma").at("beta_deg")) r.sigma_beta_deg.push_back(number_or_null(s));
    r.sigma_camera_mm = number_or_null(j.at("sigma").at("camera_mm"));
    r.sigma_camera_deg = number_or_null(j.at("sigma").at("camera_deg"));
    r.rank = j.at("rank");
    r.parameters = j.at("parameters");
    r.attempts = j.value("attempts", 1);
    r.unobservable = texts_from(j.at("unobservable"));
    r.solve_wall_ms = j.at("solve_wall_ms");
    r.model = model_from(j.at("model"));
    return r;
  });
}

AdaptResult load_adapt(const std::filesystem::path& file) {
  return read_result(file, [](const json& j) {
    AdaptResult r{model_from(j.at("model_before")), model_from(j.at("model_after")), {}};
    for (const json& look : j.at("looks")) r.looks.push_back(adapt_look(look));
    return r;
  });
}

MoveResult load_move(const std::filesystem::path& file) {
  return read_result(file, [](const json& j) {
    return MoveResult{joints_from(j.at("q_goal_real_rad")), joints_from(j.at("q_reading_rad")), j.at("state"),
                      j.at("arm_time_ns"), model_from(j.at("model"))};
  });
}

GraspResult load_grasp(const std::filesystem::path& file) {
  return read_result(file, [](const json& j) {
    GraspResult r;
    r.object = j.at("object");
    r.verdict = j.at("verdict");
    r.why = j.value("why", "");
    r.images = texts_from(j.value("images", json::array()));
    r.image_closed = j.value("image_closed", "");
    r.candidate = j.value("candidate", "");
    r.status = j.value("status", "");
    if (r.verdict == "refused") return r;  // there may be no goal to tell of
    r.T_C_O = pose_from(j.at("T_C_O"));
    r.T_O_G = pose_from(j.at("T_O_G"));
    r.T_B_G = pose_from(j.at("T_B_G"));
    r.model = model_from(j.at("model"));
    r.arm_time_ns = j.at("arm_time_ns");
    r.q_reading = joints_from(j.at("q_reading_rad"));
    r.hand_closure = j.at("hand_closure");
    r.hand_effort_permille = j.at("hand_effort_permille");
    return r;
  });
}

ControllerStatus load_status(const std::filesystem::path& file) {
  return read_result(file, [](const json& j) {
    ControllerStatus s;
    s.rate_hz = j.at("rate_hz");
    s.tick_us_p50 = j.at("tick_us_p50");
    s.tick_us_p999 = j.at("tick_us_p999");
    s.cycles = j.at("cycles");
    s.missed = j.at("missed");
    for (const json& d : j.at("durations"))
      s.durations.push_back({d.at("name"), d.at("count"), d.at("p50_us"), d.at("p999_us"), d.at("max_us"),
                             d.at("upper_ns"), d.at("counts")});
    return s;
  });
}

Truth load_truth(const std::filesystem::path& file) {
  return read_result(file, [&](const json& j) {
    Truth truth;
    truth.chain = chain_from(j.at("arm"));
    truth.before = model_from(j.at("before"));
    truth.after = model_from(j.at("after"));
    truth.drift_arm_time_ns = j.at("after").at("arm_time_ns");
    truth.T_B_O = pose_from(j.at("T_B_O"));
    for (const json& g : j.at("grasps")) {
      truth.grasps.push_back({g.at("arm_time_ns"), g.at("held"), g.at("error_m"), g.at("error_rad")});
    }
    truth.rows = load_rows(file.parent_path() / j.at("trace").get<std::string>(), truth.chain.joint_count);
    return truth;
  });
}

}  // namespace armsight::demo
