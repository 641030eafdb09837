#include "tests/system/synthetic_run.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "shared/hand_eye.hpp"

namespace armsight::demo {

namespace {

using nlohmann::json;

constexpr std::int64_t kPeriod_ns = 4'000'000;
constexpr std::int64_t kDrift_ns = 1000 * kPeriod_ns;

json list(const Eigen::Ref<const Eigen::VectorXd>& v) { return std::vector<double>(v.begin(), v.end()); }

json pose(const Pose& T) {
  const Eigen::Quaterniond quat(T.R);
  return {{"p_m", list(T.p)}, {"q_wxyz", {quat.w(), quat.x(), quat.y(), quat.z()}}};
}

json model(const LearnedModel& m) {
  return {{"revision", m.revision}, {"T_C_B", pose(m.T_C_B)}, {"beta_rad", list(m.beta)}};
}

LearnedModel between(const LearnedModel& a, const LearnedModel& b, double share) {
  const Vector3 turn = so3_log(b.T_C_B.R * a.T_C_B.R.transpose());
  return {b.revision,
          {so3_exp(share * turn) * a.T_C_B.R, a.T_C_B.p + share * (b.T_C_B.p - a.T_C_B.p)},
          a.beta + share * (b.beta - a.beta)};
}

void save(const std::filesystem::path& file, const json& j) { std::ofstream(file) << j.dump(1); }

/// Collects the rows of truth.csv as the events come.
class Trace {
 public:
  explicit Trace(const SyntheticRun& run) : run_(run) {}
  /// The arm stands at this reading; the row's time.
  std::int64_t stand_at(const JointVector& q_reading, bool is_after_drift) {
    if (is_after_drift) time_ns_ = std::max(time_ns_, kDrift_ns);
    time_ns_ += 100 * kPeriod_ns;
    const JointVector q_true = q_reading + (is_after_drift ? run_.true_after : run_.true_before).beta;
    const Pose T = forward_kinematics(run_.robot.arm.chain, q_true);
    const Eigen::Quaterniond quat(T.R);
    rows_ << time_ns_;
    for (const double q : q_true) rows_ << ',' << q;
    for (const double q : q_reading) rows_ << ',' << q;
    rows_ << ',' << T.p.x() << ',' << T.p.y() << ',' << T.p.z() << ',' << quat.w() << ',' << quat.x() << ',' << quat.y()
          << ',' << quat.z() << '\n';
    return time_ns_;
  }
  std::string rows() const { return rows_.str(); }

 private:
  const SyntheticRun& run_;
  std::int64_t time_ns_ = 0;
  std::ostringstream rows_ = [] { std::ostringstream s; s.precision(17); return s; }();
};

json calibrate_json(const SyntheticRun& run, Trace& trace) {
  json looks = json::array();
  for (int i = 0; i < 21; ++i) {
    const JointVector q = 0.3 * JointVector::LinSpaced(5, 0.1 * i, 1.0);
    looks.push_back({{"q_reading_rad", list(q)},
                     {"arm_time_ns", trace.stand_at(q, false)},
                     {"used", i != 13},
                     {"reason", i != 13 ? "" : "residual"},
                     {"residual_mm", i == 13 ? 4.2 : 0.5 + 0.3 * std::sin(1.0 * i)},
                     {"residual_deg", i == 13 ? 1.3 : 0.2 + 0.1 * std::cos(2.0 * i)},
                     {"reprojection_px", 0.3}});
  }
  return {{"looks", looks},
          {"training", {{"rms_mm", 0.62}, {"rms_deg", 0.24}}},
          {"heldout", {{"rms_mm", 0.81}, {"rms_deg", 0.31}}},
          {"sigma", {{"beta_deg", {nullptr, 0.05, 0.06, 0.08, 0.11}}, {"camera_mm", 0.6}, {"camera_deg", 0.12}}},
          {"rank", 10},
          {"parameters", 11},
          {"unobservable",
           {"The offset of joint 1 cannot be told from a turn of the base about its axis; it is held at 0."}},
          {"solve_wall_ms", 14.2},
          {"attempts", 24},
          {"images", json::array()},
          {"model", model(run.learnt)}};
}

json adapt_json(const SyntheticRun& run, Trace& trace) {
  json looks = json::array();
  for (int i = 1; i <= 5; ++i) {
    const LearnedModel after = between(run.learnt, run.adapted, 1.0 - std::pow(0.3, i));
    const CameraCorrection c = camera_correction(run.learnt.T_C_B, after.T_C_B);
    const JointVector q = JointVector::Constant(5, 0.2 + 0.1 * i);
    looks.push_back({{"outcome", "fused"},
                     {"nis", 40.0 / i},
                     {"cost", 4.0 + 0.3 * i},
                     {"gain_norm", 1.4 / i},
                     {"iterations", 3},
                     {"innovation", {0.02 / i, 0.01 / i, 0.0, 0.03 / i, 0.0, 0.01}},
                     {"q_reading_rad", list(q)},
                     {"delta_t_m", list(c.delta_t_m)},
                     {"delta_theta_rad", list(c.delta_theta_rad)},
                     {"delta_beta_rad", list(after.beta - run.learnt.beta)},
                     {"arm_time_ns", trace.stand_at(q, true)},
                     {"model", model(after)}});
  }
  looks.back()["model"] = model(run.adapted);
  return {{"model_before", model(run.learnt)}, {"model_after", model(run.adapted)}, {"looks", looks}};
}

json move_json(const JointVector& q_real, const LearnedModel& m, Trace& trace) {
  const JointVector q = q_real - m.beta;
  return {{"q_goal_real_rad", list(q_real)},
          {"state", "arrived"},
          {"arm_time_ns", trace.stand_at(q, true)},
          {"q_reading_rad", list(q)},
          {"model", model(m)}};
}

json grasp_json(const SyntheticRun& run, const LearnedModel& m, const Pose& T_B_O, const Pose& T_O_G, Trace& trace,
                std::int64_t& time_ns) {
  const JointVector q = run.experiment.commanded_q_real[2] - m.beta;
  time_ns = trace.stand_at(q, true);
  const Pose T_C_O = run.true_after.T_C_B * T_B_O;
  return {{"object", "can"},
          {"candidate", "side"},
          {"T_C_O", pose(T_C_O)},
          {"T_O_G", pose(T_O_G)},
          {"T_B_G", pose(m.T_C_B.inverse() * T_C_O * T_O_G)},
          {"model", model(m)},
          {"status", "arrived"},
          {"arm_time_ns", time_ns},
          {"q_reading_rad", list(q)},
          {"verdict", "grasped"},
          {"why", ""},
          {"hand_closure", 0.6},
          {"hand_effort_permille", 480}};
}

}  // namespace

SyntheticRun::SyntheticRun(const RobotConfig& r, const Experiment& e) : robot(r), experiment(e) {
  const Pose moved{so3_exp(Vector3(0.03, -0.02, 0.04)), Vector3(0.02, -0.01, 0.03)};
  true_before = {1, moved * robot.camera_hint_T_C_B, (JointVector(5) << 0.05, -0.04, 0.06, 0.02, -0.07).finished()};
  const Pose knocked{so3_exp(Vector3(0.03, 0.03, -0.03)), Vector3(0.01, 0.008, -0.008)};
  true_after = {2, knocked * true_before.T_C_B,
                true_before.beta + (JointVector(5) << 0.02, -0.02, 0.01, 0.03, -0.02).finished()};
  // Learnt: exact but for the gauge, with joint 1 held at 0; adapted: 1 mm beside the truth.
  const Pose turn{so3_exp(Vector3(0, 0, true_before.beta(0))), Vector3::Zero()};
  learnt = {1, true_before.T_C_B * turn, true_before.beta};
  learnt.beta(0) = 0.0;
  adapted = {6, true_after.T_C_B, true_after.beta};
  adapted.T_C_B.p.x() += 0.001;
}

void SyntheticRun::write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  Trace trace(*this);
  save(folder / "calibrate.json", calibrate_json(*this, trace));
  for (const auto& [name, m] : {std::pair{"without", &learnt}, {"with", &adapted}}) {
    for (std::size_t i = 0; i < experiment.commanded_q_real.size(); ++i) {
      save(folder / ("move-" + std::string(name) + "-" + std::to_string(i + 1) + ".json"),
           move_json(experiment.commanded_q_real[i], *m, trace));
    }
  }
  save(folder / "adapt.json", adapt_json(*this, trace));

  // The object stands where the adapted model's hand is, `grasp_error` beside a perfect grasp along the object's axis.
  const Pose T_B_H =
      forward_kinematics(robot.arm.chain, experiment.commanded_q_real[2] - adapted.beta + true_after.beta);
  const Pose T_H_O{Matrix3::Identity(), Vector3(0.035, -0.060, 0)};
  const Pose T_B_O = T_B_H * Pose{Matrix3::Identity(), Vector3(0, 0, grasp_error_with_m)} * T_H_O;
  std::int64_t with_ns = 0, without_ns = 0;
  save(folder / "grasp-without.json", grasp_json(*this, learnt, T_B_O, T_H_O.inverse(), trace, without_ns));
  save(folder / "grasp-with.json", grasp_json(*this, adapted, T_B_O, T_H_O.inverse(), trace, with_ns));

  json after = json::array();
  for (int i = 0; i < robot.arm.joint_count(); ++i)
    after.push_back(pose(robot.arm.chain.T_after[static_cast<std::size_t>(i)]));
  json truth_after = model(true_after);
  truth_after["arm_time_ns"] = kDrift_ns;
  save(folder / "truth.json",
       {{"seed", 1},
        {"noise", "nominal"},
        {"arm", {{"T_B_0", pose(robot.arm.chain.T_B_0)}, {"T_after", after}}},
        {"before", model(true_before)},
        {"after", truth_after},
        {"T_B_O", pose(T_B_O)},
        {"trace", "truth.csv"},
        {"grasps",
         {{{"arm_time_ns", without_ns}, {"held", false}, {"error_m", grasp_error_without_m}, {"error_rad", 0.07}},
          {{"arm_time_ns", with_ns}, {"held", true}, {"error_m", grasp_error_with_m}, {"error_rad", 0.006}}}}});
  std::ofstream(folder / "truth.csv") << "arm_time_ns,...\n" << trace.rows();
}

}  // namespace armsight::demo
