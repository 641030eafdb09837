// The moving parts: true joints behind their drives, the fingers, the object. Advanced in steps of at most 1 ms; reads
// of the encoder carry the errors of the truth. Real angles in rad, readings = real − beta − encoder error.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "tools/sim/joint.hpp"
#include "tools/sim/motor.hpp"
#include "tools/sim/truth.hpp"
#include "tools/sim/world_view.hpp"

namespace armsight::sim {

/// A close of the fingers, judged by truth.
struct GraspRecord {
  Time time;
  bool is_held = false;
  double error_m = 0.0, error_rad = 0.0;  ///< of the hand against the nearest grasp of the object
};

/// Distance of the hand from the nearest pose in which it would hold the object: centre of O at `centre_H`, z_H ∥ ±z_O,
/// any yaw.
GraspRecord nearest_grasp(const Pose& T_B_H, const Pose& T_B_O, const Vector3& centre_H);

class Plant {
 public:
  Plant(const RobotConfig& robot, const Scene& scene, Truth truth, Time start);
  ~Plant();

  void advance_to(Time time);
  void inject_drift();

  void set_encoder_fault(int joint, const EncoderFault& fault);
  /// Something holds this joint between two angles from now on.
  void block(int joint, double min_rad, double max_rad);
  Motor& joint_motor(int i);
  Motor& hand_motor();

  const JointVector& q_real() const;
  double speed_rad_s(int joint) const;
  Pose T_B_H() const;
  double hand_closure() const;
  const Truth& truth() const;
  const std::vector<GraspRecord>& grasps() const;
  /// Truth at a time of the last 150 ms, held at the ends. From any thread.
  WorldView view(double time_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How far beyond the limits of the readings the mechanics go: offsets of the joints and some play.
inline constexpr double kMechanicalMargin_rad = 0.25;

}  // namespace armsight::sim
