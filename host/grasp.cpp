#include "host/grasp.hpp"

#include <ostream>
#include <utility>

#include "host/grasp_plan.hpp"
#include "host/hand_looks.hpp"
#include "host/json_out.hpp"
#include "host/look_planning.hpp"
#include "host/motion.hpp"
#include "host/planned_motion.hpp"
#include "host/route.hpp"
#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr double kGraspMargin_rad = 0.03;
constexpr double kOutOfViewMargin_rad = 0.15;
constexpr double kPregraspOrientation_rad = 0.05;  // the pre-grasp is asked for as reached: only the solver's noise
constexpr double kOpenForce_permille = 500;

class Grasp {
 public:
  Grasp(HostIo& io, SessionFiles& files, const GraspObject& object, const GraspOptions& options, std::ostream& progress)
      : io_(io), files_(files), object_(object), options_(options), progress_(progress) {
    record.object = object.name;
    record.verdict = "refused";
  }

  void run();
  GraspRecord record;

 private:
  void find_object();
  bool see_object(Looker& looker);
  GraspChoice choose();
  void drive(const IkSolution& posture, const std::string& what);
  void close_hand(const GraspChoice& choice);
  void carry(const GraspChoice& choice);
  ReachProblem reach() const;
  void show(const GraspChoice& choice);
  void picture_closed();
  void note_end();
  [[noreturn]] void refuse(const std::string& why);

  HostIo& io_;
  SessionFiles& files_;
  const GraspObject& object_;
  const GraspOptions& options_;
  std::ostream& progress_;
};

void Grasp::refuse(const std::string& why) {
  record.why = why;
  note_end();
  throw CommandFailed("grasp: refused: " + why);
}

void Grasp::note_end() {
  record.model = model_in_force(io_);
  record.q_reading = reading_now(io_);
  record.arm_time_ns = io_.arm().state()->arm_time_ns();
  record.hand_closure = io_.arm().state()->hand_closure();
  record.hand_effort_permille = io_.arm().state()->hand_effort_permille();
}

void Grasp::run() {
  if (!options_.dry_run) move_hand(io_, 0.0, kOpenForce_permille);
  find_object();
  const GraspChoice choice = choose();
  record.candidate = choice.grasp;
  record.T_O_G = choice.T_O_G;
  record.T_B_G = choice.T_B_G;
  progress_ << "grasp: " << choice.grasp << ", yaw " << fixed(degrees(choice.yaw_rad), 0) << " deg, joints "
            << degrees_text(choice.at_grasp.q) << " deg" << std::endl;
  if (options_.dry_run) return show(choice);
  drive(choice.at_pregrasp, "pre-grasp");
  drive(choice.at_grasp, "grasp");
  close_hand(choice);
}

bool Grasp::see_object(Looker& looker) {
  const LookTaken taken = looker.look(options_.frames, std::nullopt);
  record.why = taken.why;
  if (!taken.look) {
    files_.save_picture(overlaid(taken, io_.camera().intrinsics(), {"act: " + object_.name, record.why}));
    return false;
  }
  if (taken.look->second_T_C_H) {
    record.why = "the object's marker is seen too frontally to tell its tilt";
    files_.save_picture(overlaid(taken, io_.camera().intrinsics(), {"act: " + object_.name, record.why}));
    return false;
  }
  record.T_C_O = taken.look->T_C_H;
  files_.save_picture(overlaid(taken, io_.camera().intrinsics(), {"act: " + object_.name}));
  progress_ << "object: " << object_.name << " at " << fixed(record.T_C_O->p.z(), 3) << " m from the camera, "
            << fixed(taken.look->reprojection_px, 2) << " px" << std::endl;
  return true;
}

void Grasp::find_object() {
  Looker looker(io_, object_.marker, object_.T_O_M);
  if (see_object(looker)) return;
  if (options_.dry_run)
    throw CommandFailed("grasp: " + record.why + " from here; a dry run moves nothing out of the way");
  const LearnedModel model = model_in_force(io_);
  const PlanProblem problem = plan_problem(
      io_, model.T_C_B, wide_prior(io_.robot().filter, io_.robot().arm.joint_count()), kOutOfViewMargin_rad);
  for (const JointVector& q : postures_out_of_view(problem, real_now(io_), options_.view_attempts)) {
    progress_ << "object: " << record.why << "; moving the arm out of the way" << std::endl;
    if (!drive_to(io_, q).has_arrived) continue;
    if (see_object(looker)) return;
  }
  refuse("object " + object_.name + ": " + record.why);
}

ReachProblem Grasp::reach() const {
  const JointLimits& limits = io_.robot().arm.limits;
  return {io_.robot().arm.chain, limits.min_rad.array() + kGraspMargin_rad, limits.max_rad.array() - kGraspMargin_rad,
          real_now(io_), io_.robot().collision};
}

GraspChoice Grasp::choose() {
  const LearnedModel model = model_in_force(io_);
  const ReachProblem problem = reach();
  const Pose T_B_O = model.T_C_B.inverse() * *record.T_C_O;
  const GraspPlan plan = io_.compute([=, this] { return plan_grasp(problem, object_, T_B_O); });
  if (plan.best) return *plan.best;
  std::string why;
  for (const std::string& refusal : plan.refusals) why += (why.empty() ? "" : "; ") + refusal;
  refuse("no grasp of " + object_.name + " is reachable: " + why);
}

// The goal goes out in the camera's frame with its model revision, as the posture reaches it: the controller maps it
// with the model in force and finds the same posture.
void Grasp::drive(const IkSolution& posture, const std::string& what) {
  const LearnedModel model = model_in_force(io_);
  PoseTarget target;
  target.frame = wire::GOAL_FRAME_CAMERA;
  target.T_X_G = model.T_C_B * forward_kinematics(io_.robot().arm.chain, posture.q);
  target.model_revision = model.revision;
  target.position_tolerance_m = object_.position_tolerance_m;
  target.orientation_tolerance_rad = kPregraspOrientation_rad;
  target.q_seed = posture.q;
  const std::vector<JointVector> route = find_route(io_.robot(), model, real_now(io_), posture.q);
  if (route.size() > 1) (void)drive_to(io_, route.front());  // out of the way first; what follows says how that went
  const MotionResult motion = drive_to(io_, target);
  record.status = what + ": " + (motion.has_arrived ? "arrived" : motion.why);
  progress_ << record.status << std::endl;
  if (!motion.has_arrived) refuse(record.status);
}

void Grasp::close_hand(const GraspChoice& choice) {
  const HandResult hand = move_hand(io_, 1.0, object_.force_limit_permille);
  note_end();
  const GraspVerdict verdict = judge_grasp(object_, hand.closure, hand.effort_permille);
  record.verdict = to_text(verdict);
  record.why = "fingers at " + fixed(100 * hand.closure, 0) + " % with " + fixed(hand.effort_permille / 10, 0) +
               " % of their force";
  progress_ << "hand: " << record.verdict << ": " << record.why << std::endl;
  picture_closed();
  if (verdict == GraspVerdict::kGrasped) return carry(choice);
  move_hand(io_, 0.0, kOpenForce_permille);
  (void)drive_to(io_, choice.at_pregrasp.q);  // back the way it came; the verdict stands whatever becomes of it
}

// The verdict on the grasp stands with its time and place; only an object that is lost on the way revokes it.
void Grasp::carry(const GraspChoice& choice) {
  if (options_.then == AfterGrasp::kStay) return;
  const bool is_lift = options_.then == AfterGrasp::kLift;
  const Vector3 up_B = -io_.robot().gravity_m_s2.normalized();
  const std::optional<JointVector> q = is_lift ? plan_lift(reach(), up_B) : choice.at_pregrasp.q;
  record.then = is_lift ? "lift" : "retreat";
  if (!q) {
    record.then += ": no posture above this one; stayed";
  } else {
    const MotionResult motion = drive_to(io_, *q);
    record.then += ": " + (motion.has_arrived ? "arrived" : motion.why);
  }
  progress_ << record.then << std::endl;
  const wire::ArmState& state = *io_.arm().state();
  if (judge_grasp(object_, state.hand_closure(), state.hand_effort_permille()) == GraspVerdict::kGrasped) return;
  record.verdict = to_text(GraspVerdict::kEmpty);
  record.why = "grasped, but lost after: " + record.then;
}

void Grasp::show(const GraspChoice& choice) {
  const RobotConfig& robot = io_.robot();
  const LearnedModel model = model_in_force(io_);
  progress_ << "dry run: nothing moves" << std::endl;
  tell("pre-grasp", plan_motion(robot, model, real_now(io_), choice.at_pregrasp.q, io_.speed_scale()), robot,
       progress_);
  tell("grasp", plan_motion(robot, model, choice.at_pregrasp.q, choice.at_grasp.q, io_.speed_scale()), robot,
       progress_);
  progress_ << "then: the hand closes with at most " << fixed(object_.force_limit_permille / 10, 0) << " % of its force"
            << std::endl;
  record.verdict = "planned";
}

// What the camera saw of the verdict, for people: it decides nothing.
void Grasp::picture_closed() {
  Looker looker(io_, io_.robot().hand_marker, io_.robot().arm.T_H_M);
  const LearnedModel& model = record.model;
  const Pose predicted = predict_T_C_H(io_.robot().arm.chain, model.T_C_B, model.beta, record.q_reading);
  const LookTaken taken = looker.look(1, predicted);
  record.image_closed = files_.save_picture(
      overlaid(taken, io_.camera().intrinsics(), {"act: hand closed: " + record.verdict, record.why}));
}

}  // namespace

void run_grasp(HostIo& io, SessionFiles& files, const GraspObject& object, const GraspOptions& options,
               std::ostream& progress) {
  Grasp grasp(io, files, object, options, progress);
  try {
    grasp.run();
  } catch (const CommandFailed&) {
    grasp.record.images = files.pictures();
    files.save_result(to_json(grasp.record));
    throw;
  }
  grasp.record.images = files.pictures();
  files.save_result(to_json(grasp.record));
  if (grasp.record.verdict == to_text(GraspVerdict::kEmpty))
    throw CommandFailed("grasp: the hand is empty: " + grasp.record.why);
}

}  // namespace armsight::host
