#include "host/calibrate.hpp"

#include <algorithm>
#include <ostream>
#include <utility>

#include "host/calibrate_files.hpp"
#include "host/first_sight.hpp"
#include "host/json_out.hpp"
#include "host/look_planning.hpp"
#include "host/motion.hpp"
#include "host/running_guess.hpp"
#include "host/text.hpp"
#include "protocol/convert.hpp"

namespace armsight::host {
namespace {

constexpr double kLearnMargin_rad = 0.16;        // offsets up to 8 degrees, and the controller's own margin
constexpr double kControllerMargin_rad = 0.01;
constexpr int kSolveFrom = 6;               // looks from which the batch solution replaces the filter's guess
constexpr int kPlanAheadFrom = 8;           // looks from which a whole tour is planned at once
constexpr int kMissesToDoubt = 3;           // in a row: the guess is wrong, e.g. from the wrong planar solution
constexpr int kMissesToSearch = 8;          // in a row: what was seen is lost
constexpr double kNearby_rad = 0.25;        // keeps a marker that was seen in the picture, whatever the guess

class Learn {
 public:
  Learn(HostIo& io, SessionFiles& files, const CalibrateOptions& options, std::ostream& progress)
      : io_(io), files_(files), options_(options), progress_(progress),
        looker_(io, io.robot().hand_marker, io.robot().arm.T_H_M), guess_(io.robot().arm, io.robot().filter),
        looks_(files.folder() / "looks", io.robot(), options.robot_file) {}

  void gather();
  ArmCalibration solve(bool against_previous);
  CalibrateRecord record;
  const std::vector<LookSample>& samples() const { return samples_; }

 private:
  bool is_enough() const;
  void take(const LookTaken& taken);
  void visit(const JointVector& q_plan);
  void plan();
  bool plan_nearby();
  CalibrationOptions learn_options() const;

  HostIo& io_;
  SessionFiles& files_;
  const CalibrateOptions& options_;
  std::ostream& progress_;
  Looker looker_;
  RunningGuess guess_;
  LookFiles looks_;
  std::vector<LookSample> samples_;
  std::vector<JointVector> visited_;  ///< real angles as planned: not again
  std::vector<Vector3> hidden_;       ///< places in C where the marker was not seen
  std::vector<JointVector> queue_;    ///< planned, next last
  int misses_ = 0;                    ///< postures in a row that did not show the marker
  bool is_solved_ = false;            ///< the guess is a batch solution's
};

void Learn::gather() {
  take(find_marker(io_, looker_, options_.frames, progress_).taken);
  while (!is_enough()) {
    if (record.attempts >= options_.max_attempts) return;
    if (misses_ >= kMissesToSearch && !is_solved_) {
      take(find_marker(io_, looker_, options_.frames, progress_).taken);
      continue;
    }
    if (queue_.empty() || static_cast<int>(samples_.size()) < kPlanAheadFrom) plan();
    if (queue_.empty()) {
      progress_ << "plan: no further posture shows the marker" << std::endl;
      return;
    }
    const JointVector next = queue_.back();
    queue_.pop_back();
    visit(next);
  }
}

bool Learn::is_enough() const {
  if (static_cast<int>(samples_.size()) >= options_.looks) return true;
  if (options_.target_sigma_m <= 0.0 || static_cast<int>(samples_.size()) < kSolveFrom) return false;
  const auto is_known = [&](const LookSample& s) {
    return guess_.hand_position_sigma_m(s.q_reading) < options_.target_sigma_m;
  };
  return std::all_of(samples_.begin(), samples_.end(), is_known);
}

// Where the guess misled thrice, looks beside the last good one need no guess, and mend it.
bool Learn::plan_nearby() {
  if (misses_ < kMissesToDoubt || is_solved_) return false;
  if (misses_ == kMissesToDoubt) {
    progress_ << "plan: the marker is not where one look says; looking beside the last one" << std::endl;
    hidden_.clear();
  }
  const JointVector seen = samples_.back().q_reading + guess_.model().beta;
  const ArmModel& arm = io_.robot().arm;
  const JointVector lower = arm.limits.min_rad.array() + kLearnMargin_rad,
                    upper = arm.limits.max_rad.array() - kLearnMargin_rad;
  queue_ = {posture_near(seen, kNearby_rad, lower, upper, record.attempts)};
  return true;
}

void Learn::plan() {
  if (plan_nearby()) return;
  PlanProblem problem = plan_problem(io_, guess_.model().T_C_B, guess_.covariance(), kLearnMargin_rad);
  problem.hidden = hidden_;
  const int missing = options_.looks - static_cast<int>(samples_.size());
  const bool is_tour = static_cast<int>(samples_.size()) >= kPlanAheadFrom;
  const JointVector here = reading_now(io_) + guess_.model().beta;
  queue_ = io_.compute([=, this] { return plan_looks(problem, missing, visited_, here, is_tour); });
  std::reverse(queue_.begin(), queue_.end());
}

void Learn::visit(const JointVector& q_plan) {
  ++record.attempts;
  visited_.push_back(q_plan);
  // The controller subtracts the beta in force, the plan means the beta guessed here.
  const JointVector q_reading = q_plan - guess_.model().beta;
  const JointLimits& limits = io_.robot().arm.limits;
  const JointVector q_goal = (q_reading + model_in_force(io_).beta)
                                 .cwiseMax((limits.min_rad.array() + kControllerMargin_rad).matrix())
                                 .cwiseMin((limits.max_rad.array() - kControllerMargin_rad).matrix());
  const MotionResult motion = drive_to(io_, q_goal);
  if (!motion.has_arrived) {
    progress_ << "posture " << degrees_text(q_goal) << ": " << motion.why << std::endl;
    return;
  }
  const Pose predicted = guess_.predict(reading_now(io_));
  const LookTaken taken = looker_.look(options_.frames, predicted);
  if (taken.look && taken.q_reading.size() > 0) {
    take(taken);
    return;
  }
  progress_ << "posture " << degrees_text(q_goal) << ": " << taken.why << std::endl;
  files_.save_picture(overlaid(taken, io_.camera().intrinsics(), {"learn"}));
  ++misses_;
  hidden_.push_back((predicted * io_.robot().arm.T_H_M).p);
  queue_.clear();  // plan again
}

void Learn::take(const LookTaken& taken) {
  const LookMeasurement& look = *taken.look;
  LookSample sample{
      taken.q_reading, look.T_C_H, look.second_T_C_H, look.covariance, to_ns(taken.arm_time.arm_time), {}};
  sample.image = files_.save_picture(
      overlaid(taken, io_.camera().intrinsics(), {"learn: look " + std::to_string(samples_.size() + 1)}));
  io_.compute([&] { looks_.add(sample); });  // a disk may take longer than the lease lives
  record.looks.push_back({sample.q_reading, sample.arm_time_ns, look.reprojection_px, sample.image});
  samples_.push_back(std::move(sample));
  misses_ = 0;
  guess_.take(samples_);
  if (static_cast<int>(samples_.size()) >= kSolveFrom) {
    const ArmCalibration calibration = solve(false);
    if (calibration.accepted) guess_.take(calibration);
    is_solved_ |= calibration.accepted;
  }
  progress_ << "look " << samples_.size() << "/" << options_.looks << ": joints " << degrees_text(taken.q_reading)
            << " deg, " << fixed(look.reprojection_px, 2) << " px, hand known to "
            << fixed(guess_.hand_position_sigma_m(taken.q_reading) * 1e3, 1) << " mm" << std::endl;
}

CalibrationOptions Learn::learn_options() const {
  CalibrationOptions options;
  options.encoder_sigma_rad = io_.robot().filter.encoder_sigma_rad;
  options.floor_position_sigma_m = io_.robot().filter.floor_position_sigma_m;
  options.floor_rotation_sigma_rad = io_.robot().filter.floor_rotation_sigma_rad;
  options.beta1_sigma_rad = io_.robot().filter.prior_beta1_sigma_rad;
  options.joint_names = io_.robot().joint_names;
  return options;
}

// against_previous: the held-out looks must also be predicted better than by the model in force (F-C8).
ArmCalibration Learn::solve(bool against_previous) {
  CalibrationOptions options = learn_options();
  const LearnedModel previous = model_in_force(io_);
  if (against_previous && previous.revision > 0) options.previous = previous;
  return io_.compute([this, options] { return calibrate_arm(io_.robot().arm, samples_, options); });
}

void propose(HostIo& io, const ArmCalibration& calibration) {
  wire::Envelope message;
  wire::ModelProposal& proposal = *message.mutable_model_proposal();
  const std::uint64_t parent = model_in_force(io).revision;
  proposal.set_parent_revision(parent);
  to_wire(calibration.model.T_C_B, proposal.mutable_base_in_camera());
  to_wire(calibration.model.beta, proposal.mutable_beta_rad());
  to_wire(calibration.covariance, proposal.mutable_covariance());
  proposal.set_source("calibration");
  io.demand(std::move(message), "model proposal");
  const auto is_in_force = [&] { return io.arm().model()->revision() != parent; };
  if (!io.wait_until(is_in_force, kModelTimeout))
    throw PeerLost("arm controller: the accepted model is not in force after 20 s");
}

void tell(const ArmCalibration& c, std::ostream& progress) {
  progress << "held out: " << fixed(c.heldout.rms_mm, 2) << " mm, " << fixed(c.heldout.rms_deg, 2) << " deg; training "
           << fixed(c.training.rms_mm, 2) << " mm, " << fixed(c.training.rms_deg, 2) << " deg; rank " << c.rank
           << " of " << c.parameters << std::endl;
  for (const std::string& sentence : c.unobservable) progress << "not observable: " << sentence << std::endl;
}

}  // namespace

void run_calibrate(HostIo& io, SessionFiles& files, const CalibrateOptions& options, std::ostream& progress) {
  Learn learn(io, files, options, progress);
  learn.gather();
  CalibrateRecord& record = learn.record;
  record.calibration = learn.solve(true);
  record.images = files.pictures();
  record.model = model_in_force(io);
  const ArmCalibration& calibration = record.calibration;
  tell(calibration, progress);
  if (!calibration.accepted) {
    files.save_result(to_json(record));
    throw CommandFailed("calibrate: " + calibration.why);
  }
  propose(io, calibration);
  record.model = model_in_force(io);
  save_calibration(files.folder() / "calibration.yaml", io.robot(), record.model, calibration);
  files.save_result(to_json(record));
  progress << "model " << record.model.revision << " is in force" << std::endl;
}

}  // namespace armsight::host
