#include "host/adapt.hpp"

#include <cmath>
#include <ostream>
#include <utility>

#include "host/hand_looks.hpp"
#include "host/json_out.hpp"
#include "host/look_planning.hpp"
#include "host/motion.hpp"
#include "host/text.hpp"
#include "protocol/convert.hpp"

namespace armsight::host {
namespace {

constexpr double kAdaptMargin_rad = 0.10;   // drifted offsets, and the controller's own margin

class Adapt {
 public:
  Adapt(HostIo& io, SessionFiles& files, const AdaptOptions& options, std::ostream& progress)
      : io_(io), files_(files), options_(options), progress_(progress),
        looker_(io, io.robot().hand_marker, io.robot().arm.T_H_M) {}

  void run();
  /// Fewer than half of the looks asked for, and the hand not known as well as asked for either.
  bool has_too_few() const { return fused == 0 || (2 * fused < options_.looks && !is_known_well()); }
  AdaptRecord record;
  int fused = 0;

 private:
  StateMatrix covariance() const;
  std::optional<JointVector> next_posture();
  void visit(const JointVector& q_real);
  void open(bool keep_covariance);
  void fuse(const LookTaken& taken);
  CommandOutcome send(const LookTaken& taken);
  void note(const wire::FilterReport& report, const LookTaken& taken);
  bool is_known_well() const;

  HostIo& io_;
  SessionFiles& files_;
  const AdaptOptions& options_;
  std::ostream& progress_;
  Looker looker_;
  std::vector<JointVector> visited_;
  std::vector<Vector3> hidden_;  ///< places in C where the marker was not seen
  int taken_ = 0;  ///< looks the filter has answered
};

void Adapt::run() {
  record.before = model_in_force(io_);
  open(false);
  while (taken_ < options_.looks && record.attempts < options_.max_attempts && !is_known_well()) {
    const std::optional<JointVector> next = next_posture();
    if (!next) {
      progress_ << "plan: no further posture shows the marker" << std::endl;
      break;
    }
    ++record.attempts;
    visit(*next);
  }
  record.after = model_in_force(io_);
}

// The filter's, once it has told one since the start; before that its wide prior.
StateMatrix Adapt::covariance() const {
  const int joints = io_.robot().arm.joint_count();
  StateMatrix P;
  const auto& told = io_.arm().model()->covariance();
  if (taken_ == 0 || from_wire(told, "covariance", kErrorBeta + joints, P))
    return wide_prior(io_.robot().filter, joints);
  return P;
}

std::optional<JointVector> Adapt::next_posture() {
  PlanProblem problem = plan_problem(io_, model_in_force(io_).T_C_B, covariance(), kAdaptMargin_rad);
  problem.hidden = hidden_;
  const int missing = options_.looks - taken_;
  const JointVector here = real_now(io_);
  const auto plan = io_.compute([=, this] { return plan_looks(problem, missing, visited_, here, false); });
  if (plan.empty()) return std::nullopt;
  return plan.front();
}

void Adapt::visit(const JointVector& q_real) {
  visited_.push_back(q_real);
  const MotionResult motion = drive_to(io_, q_real);
  if (!motion.has_arrived) {
    progress_ << "posture " << degrees_text(q_real) << ": " << motion.why << std::endl;
    return;
  }
  const LearnedModel model = model_in_force(io_);
  const Pose predicted = predict_T_C_H(io_.robot().arm.chain, model.T_C_B, model.beta, reading_now(io_));
  const LookTaken taken = looker_.look(options_.frames, predicted);
  if (taken.look) {
    fuse(taken);
    return;
  }
  hidden_.push_back((predicted * io_.robot().arm.T_H_M).p);
  progress_ << "posture " << degrees_text(q_real) << ": " << taken.why << std::endl;
  files_.save_picture(overlaid(taken, io_.camera().intrinsics(), {"adapt"}));
}

/// keep_covariance: goes on where a lost lease closed it.
void Adapt::open(bool keep_covariance) {
  wire::Envelope start;
  start.mutable_recalibration_start()->set_keep_covariance(keep_covariance);
  io_.demand(std::move(start), "recalibration");
}

void Adapt::fuse(const LookTaken& taken) {
  CommandOutcome outcome = send(taken);
  const bool was_closed =
      outcome.reason == wire::REFUSAL_REASON_NO_LEASE || outcome.reason == wire::REFUSAL_REASON_WRONG_STATE;
  if (!outcome.is_accepted && was_closed) {
    open(true);
    outcome = send(taken);
  }
  if (!outcome.is_accepted) progress_ << "look refused: " << outcome.text << std::endl;
}

CommandOutcome Adapt::send(const LookTaken& taken) {
  const LookMeasurement& look = *taken.look;
  wire::Envelope message;
  wire::HandPose& pose = *message.mutable_hand_pose();
  pose.set_arm_capture_time_ns(to_ns(taken.arm_time.arm_time));
  pose.set_time_bound_ns(taken.arm_time.bound.count());
  to_wire(look.T_C_H, pose.mutable_hand_in_camera());
  if (look.second_T_C_H) to_wire(*look.second_T_C_H, pose.mutable_hand_in_camera_second());
  to_wire(look.covariance, pose.mutable_covariance());
  pose.set_reprojection_error_px(look.reprojection_px);
  pose.set_marker_id(static_cast<std::uint32_t>(look.id));
  pose.set_frames(static_cast<std::uint32_t>(look.frames));

  const std::uint64_t sequence = io_.arm().send(std::move(message));
  std::optional<wire::FilterReport> report;
  const auto is_refused = [&] { return io_.arm().outcome(sequence) && !io_.arm().outcome(sequence)->is_accepted; };
  const auto is_answered = [&] { return (report = io_.arm().take_filter_report()) || is_refused(); };
  if (!io_.wait_until(is_answered, kModelTimeout)) throw PeerLost("arm controller: no filter report within 20 s");
  if (!report) return *io_.arm().outcome(sequence);
  const auto has_model = [&] { return io_.arm().model()->revision() >= report->model_revision(); };
  if (!io_.wait_until(has_model, kModelTimeout))
    throw PeerLost("arm controller: the filter's model did not come within 20 s");
  note(*report, taken);
  return {true, {}, {}};
}

void Adapt::note(const wire::FilterReport& report, const LookTaken& taken) {
  ++taken_;
  const bool is_fused =
      report.outcome() == wire::FUSION_OUTCOME_FUSED || report.outcome() == wire::FUSION_OUTCOME_FUSED_SECOND_SOLUTION;
  if (is_fused) ++fused;
  const std::string image = files_.save_picture(overlaid(
      taken, io_.camera().intrinsics(), {"adapt: look " + std::to_string(taken_) + ", " + to_text(report.outcome())}));
  record.looks.push_back({report, model_in_force(io_), image});
  progress_ << "look " << taken_ << "/" << options_.looks << ": " << to_text(report.outcome()) << ", nis "
            << fixed(report.nis(), 1);
  if (report.innovation_size() == 6) {
    const auto& e = report.innovation();
    progress_ << ", off by " << fixed(1e3 * std::hypot(e[0], e[1], e[2]), 1) << " mm, "
              << fixed(degrees(std::hypot(e[3], e[4], e[5])), 2) << " deg";
  }
  progress_ << ", model " << report.model_revision() << std::endl;
}

bool Adapt::is_known_well() const {
  if (options_.target_sigma_m <= 0.0 || record.looks.empty()) return false;
  const auto& sigma = record.looks.back().report.hand_sigma();
  return sigma.size() == 6 && std::hypot(sigma[0], sigma[1], sigma[2]) < options_.target_sigma_m;
}

}  // namespace

void run_adapt(HostIo& io, SessionFiles& files, const AdaptOptions& options, std::ostream& progress) {
  Adapt adapt(io, files, options, progress);
  adapt.run();
  files.save_result(to_json(adapt.record));
  if (adapt.has_too_few())
    throw CommandFailed("adapt: only " + std::to_string(adapt.fused) + " of " + std::to_string(options.looks) +
                        " looks were fused in " + std::to_string(adapt.record.attempts) +
                        " attempts; at least half must be");
  progress << "model " << adapt.record.after.revision << " is in force" << std::endl;
}

}  // namespace armsight::host
