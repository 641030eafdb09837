// Looks at the hand marker without a picture: corners projected, disturbed and solved for the pose (both planar
// solutions), as specification §5.4, §5.5 and §7.1 describe them. Truth is known to the test only.
#pragma once

#include <random>
#include <vector>

#include "shared/joint_offset_ekf.hpp"

namespace armsight::test {

struct LookNoise {
  double corner_sigma_px = 0.25;
  double encoder_sigma_rad = 0.0;
  double floor_position_sigma_m = 0.0;    ///< of the hand pose, a look: stands for what the filter's floor budgets
  double floor_rotation_sigma_rad = 0.0;  ///< (mount, lens, links: specification §5.4), where it is as large as claimed
};

struct TrueRobot {
  ArmModel arm;
  Pose T_C_B;
  JointVector beta;
};

/// Default robot at its nominal mount with known offsets.
TrueRobot true_robot(std::mt19937& random);

/// A wrong model: truth displaced by [v; w; ε_β] with these sigmas.
LearnedModel disturbed_model(const TrueRobot& truth, double position_sigma_m, double rotation_sigma_rad,
                             double beta_sigma_rad, double beta1_sigma_rad, std::mt19937& random);

/// The wide prior of specification §5.5 times a scale.
EkfOptions scaled_options(double scale);

/// The same with the sigmas of a filter's wide prior.
LearnedModel disturbed_by(const TrueRobot& truth, const EkfOptions& prior, std::mt19937& random);

/// The direction of the state that no look can see: the camera turned about joint 1, its offset turned back.
StateVector gauge_direction();

/// Random posture (real angles) whose marker is inside the picture by 90 px and tilted by 12–58° (§7.3).
JointVector random_visible_posture(const TrueRobot& truth, std::mt19937& random);

/// One look at the real posture; `flipped` swaps the two planar solutions.
HandPoseMeasurement look_at(const TrueRobot& truth, const JointVector& q_real, const LookNoise& noise, bool flipped,
                            std::mt19937& random);

/// Hand pose error of a model at a real posture: what every figure judges.
Vector6 hand_error(const TrueRobot& truth, const LearnedModel& model, const JointVector& q_real);

/// Quantile of values, q in [0, 1].
double quantile(std::vector<double> values, double q);

}  // namespace armsight::test
