#include "tools/replay/filter_replay.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>

#include "protocol/convert.hpp"

namespace armsight::replay {
namespace {

void check(const std::optional<Refused>& refused, const std::string& where) {
  if (refused) throw RecordingError(where + ": " + refused->text);
}

/// What a host sent and the controller has not answered yet, by peer and sequence.
using Pending = std::map<std::pair<std::string, std::uint64_t>, wire::Envelope>;

class Replayer {
 public:
  Replayer(const RobotConfig& robot, std::int64_t start_ns)
      : robot_(robot), filter_(robot.arm.chain, robot.filter), start_ns_(start_ns) {}

  void take(const wire::LinkRecord& record);
  std::vector<FilterStep> finish();

 private:
  void take_model(const wire::ModelUpdate& update);
  void take_answer(const wire::LinkRecord& record);
  void take_report(const wire::FilterReport& report, std::int64_t now_ns);
  void walk_until(std::int64_t arm_time_ns);

  const RobotConfig& robot_;
  JointOffsetEkf filter_;
  std::uint64_t revision_ = 0;
  bool has_model_ = false;
  std::int64_t start_ns_;                  ///< of the controller: its start model bears no time
  std::int64_t walked_until_ns_ = 0;
  Pending pending_;
  std::map<std::int64_t, wire::HandPose> looks_;  ///< accepted or not, by capture time
  std::vector<FilterStep> steps_;
};

void Replayer::take(const wire::LinkRecord& record) {
  const wire::Envelope& e = record.envelope();
  if (record.to_controller()) {
    if (e.has_recalibration_start()) pending_[{record.peer(), e.sequence()}] = e;
    if (e.has_hand_pose()) looks_[e.hand_pose().arm_capture_time_ns()] = e.hand_pose();
    return;
  }
  if (e.has_model_update()) take_model(e.model_update());
  if (e.has_accepted()) take_answer(record);
  if (e.has_filter_report()) take_report(e.filter_report(), e.sent_time_ns());
}

/// A model that the filter did not make itself: loaded, nominal, or from a calibration.
void Replayer::take_model(const wire::ModelUpdate& update) {
  if (has_model_ && update.revision() == revision_) return;
  LearnedModel model;
  model.revision = update.revision();
  const std::string where = "model_update of revision " + std::to_string(update.revision());
  check(from_wire(update.base_in_camera(), "base_in_camera", model.T_C_B), where);
  check(from_wire(update.beta_rad(), "beta_rad", robot_.arm.joint_count(), model.beta), where);
  StateMatrix P;
  if (update.covariance_size() > 0) {
    check(from_wire(update.covariance(), "covariance", 6 + robot_.arm.joint_count(), P), where);
    filter_.reset(model, P);
  } else {
    filter_.reset(model);
  }
  revision_ = model.revision;
  walked_until_ns_ = update.arm_time_ns() != 0 ? update.arm_time_ns() : start_ns_;
  has_model_ = true;
}

void Replayer::take_answer(const wire::LinkRecord& record) {
  const auto found = pending_.find({record.peer(), record.envelope().accepted().accepted_sequence()});
  if (found == pending_.end()) return;
  if (!found->second.recalibration_start().keep_covariance()) {
    filter_.reset(filter_.model());
    walked_until_ns_ = record.envelope().sent_time_ns() - seconds_to_duration(robot_.controller.period_s).count();
  }
  pending_.erase(found);
}

void Replayer::walk_until(std::int64_t arm_time_ns) {
  const double period_s = robot_.controller.period_s;
  const double cycles = std::round(1e-9 * static_cast<double>(arm_time_ns - walked_until_ns_) / period_s);
  if (cycles > 0.0) filter_.predict(cycles * period_s);
  walked_until_ns_ = arm_time_ns;
}

void Replayer::take_report(const wire::FilterReport& report, std::int64_t now_ns) {
  const std::string where = "filter_report of " + std::to_string(report.arm_capture_time_ns()) + " ns";
  if (!has_model_) throw RecordingError(where + ": no model_update before it");
  const bool left_no_trace = report.outcome() == wire::FUSION_OUTCOME_NO_JOINTS ||
                             report.outcome() == wire::FUSION_OUTCOME_MOVING ||
                             report.outcome() == wire::FUSION_OUTCOME_IMPLAUSIBLE;
  if (left_no_trace) return;
  const auto look = looks_.find(report.arm_capture_time_ns());
  if (look == looks_.end()) throw RecordingError(where + ": its hand_pose is not in the recording");
  HandPoseMeasurement z;
  check(from_wire(look->second.hand_in_camera(), "hand_in_camera", z.T_C_H), where);
  z.has_second = look->second.has_hand_in_camera_second();
  if (z.has_second)
    check(from_wire(look->second.hand_in_camera_second(), "hand_in_camera_second", z.T_C_H_second), where);
  StateMatrix covariance;
  check(from_wire(look->second.covariance(), "covariance", 6, covariance), where);
  z.R_vision = covariance;
  check(from_wire(report.q_reading_rad(), "q_reading_rad", robot_.arm.joint_count(), z.q), where);

  // The tick takes a look before it walks: the walk of the look's own cycle comes after it.
  walk_until(now_ns - seconds_to_duration(robot_.controller.period_s).count());
  FilterStep step;
  step.arm_capture_time_ns = report.arm_capture_time_ns();
  step.report = filter_.update(z);
  const bool is_fused =
      step.report.outcome == FusionOutcome::kFused || step.report.outcome == FusionOutcome::kFusedSecondSolution;
  if (is_fused) ++revision_;
  step.model = filter_.model();
  step.model.revision = revision_;
  step.hand_sigma = filter_.predicted_hand_covariance(z.q).diagonal().cwiseMax(0.0).cwiseSqrt();
  step.recorded = report;
  steps_.push_back(step);
}

std::vector<FilterStep> Replayer::finish() {
  if (steps_.empty()) throw RecordingError("holds no look that reached the filter (hand_pose and its filter_report)");
  return std::move(steps_);
}

const char* to_text(FusionOutcome outcome) {
  switch (outcome) {
    case FusionOutcome::kFused: return "fused";
    case FusionOutcome::kFusedSecondSolution: return "fused_second_solution";
    case FusionOutcome::kRejectedByGate: return "rejected_by_gate";
    case FusionOutcome::kIllConditioned: return "ill_conditioned";
    case FusionOutcome::kNotFinite: break;
  }
  return "not_finite";
}

class Row {
 public:
  Row& number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, ",%.10g", value);
    text_ += text;
    return *this;
  }
  template <typename Derived>
  Row& numbers(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) number(values[i]);
    return *this;
  }
  std::string text_;
};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

bool is_same_cell(const std::string& a, const std::string& b) {
  char *end_a = nullptr, *end_b = nullptr;
  const double x = std::strtod(a.c_str(), &end_a), y = std::strtod(b.c_str(), &end_b);
  const bool are_numbers = !a.empty() && !b.empty() && *end_a == '\0' && *end_b == '\0';
  if (!are_numbers) return a == b;
  return std::abs(x - y) <= std::max(1e-12, 1e-9 * std::max(std::abs(x), std::abs(y)));
}

std::int64_t first_answer_ns(const LinkFile& file) {
  for (const wire::LinkRecord& record : file.messages)
    if (!record.to_controller()) return record.envelope().sent_time_ns();
  return 0;
}

}  // namespace

std::vector<FilterStep> replay_filter(const LinkFile& file, const RobotConfig& robot) {
  const bool is_of_controller = file.info && !file.info->configuration().empty();
  Replayer replayer(robot, is_of_controller ? file.info->time_ns() : first_answer_ns(file));
  for (const wire::LinkRecord& record : file.messages) replayer.take(record);
  return replayer.finish();
}

bool is_of_the_filter(const wire::LinkRecord& record) {
  const wire::Envelope& e = record.envelope();
  return e.has_hello() || e.has_hello_reply() || e.has_bye() || e.has_recalibration_start() || e.has_hand_pose() ||
         e.has_accepted() || e.has_refusal() || e.has_model_proposal() || e.has_model_update() || e.has_filter_report();
}

std::string to_csv(const std::vector<FilterStep>& steps) {
  std::string csv =
      "arm_capture_time_ns,outcome,revision,iterations,nis,cost,gain_norm,innovation_x_m,innovation_y_m,innovation_z_m,"
      "innovation_rx_rad,innovation_ry_rad,innovation_rz_rad,T_C_B_x_m,T_C_B_y_m,T_C_B_z_m,T_C_B_qw,T_C_B_qx,T_C_B_qy,"
      "T_C_B_qz,"
      "sigma_x_m,sigma_y_m,sigma_z_m,sigma_rx_rad,sigma_ry_rad,sigma_rz_rad";
  const Eigen::Index joints = steps.empty() ? 0 : steps.front().model.beta.size();
  for (Eigen::Index i = 1; i <= joints; ++i) csv += ",beta_" + std::to_string(i) + "_rad";
  for (const FilterStep& step : steps) {
    Row row;
    row.text_ = "\n" + std::to_string(step.arm_capture_time_ns) + "," + to_text(step.report.outcome) + "," +
                std::to_string(step.model.revision) + "," + std::to_string(step.report.iterations);
    wire::Pose T_C_B;
    armsight::to_wire(step.model.T_C_B, &T_C_B);
    row.number(step.report.nis).number(step.report.cost).number(step.report.gain_norm).numbers(step.report.innovation);
    row.number(T_C_B.x_m()).number(T_C_B.y_m()).number(T_C_B.z_m());
    row.number(T_C_B.qw()).number(T_C_B.qx()).number(T_C_B.qy()).number(T_C_B.qz());
    row.numbers(step.hand_sigma).numbers(step.model.beta);
    csv += row.text_;
  }
  return csv + "\n";
}

std::string first_csv_difference(const std::string& golden, const std::string& now) {
  const std::vector<std::string> a = split(golden, '\n'), b = split(now, '\n');
  if (a.empty() || b.empty() || a[0] != b[0]) return "the columns differ";
  if (a.size() != b.size())
    return "golden has " + std::to_string(a.size() - 1) + " looks, now " + std::to_string(b.size() - 1);
  const std::vector<std::string> names = split(a[0], ',');
  for (std::size_t row = 1; row < a.size(); ++row) {
    const std::vector<std::string> x = split(a[row], ','), y = split(b[row], ',');
    for (std::size_t i = 0; i < names.size(); ++i)
      if (i >= x.size() || i >= y.size() || !is_same_cell(x[i], y[i]))
        return "look " + std::to_string(row) + ", " + names[i] + ": golden " + (i < x.size() ? x[i] : "nothing") +
               ", now " + (i < y.size() ? y[i] : "nothing");
  }
  return {};
}

}  // namespace armsight::replay
