// Adapt: the extended Kalman filter that corrects camera-base pose and joint offsets from looks at the hand;
// thesis ch. 5 in the base-frame error-state form of specification §5.1, floored, iterated, damped and gated (§5.5).
// State x = [v; w; ε_β], folded into the model after each update. No heap, no throw.
#pragma once

#include "shared/hand_eye.hpp"

namespace armsight {

/// One look: the hand pose that the camera measured, the alternative planar solution, and the reading at that time.
struct HandPoseMeasurement {
  Pose T_C_H;
  Pose T_C_H_second;        ///< the other IPPE solution, as hand pose
  bool has_second = false;
  Matrix6 R_vision = Matrix6::Zero();  ///< covariance of the hand pose in C from the corners; the filter adds the rest
  JointVector q;            ///< encoder readings at mid-exposure
};

struct EkfOptions {
  double prior_position_sigma_m = 0.03;
  double prior_rotation_sigma_rad = 0.07;
  double prior_beta_sigma_rad = 0.052;
  double prior_beta1_sigma_rad = 0.0087;   ///< tight: the gauge goes to the camera (specification §5.3)
  double encoder_sigma_rad = 0.00175;      ///< R_q of one look, per joint
  double floor_position_sigma_m = 0.001;
  double floor_rotation_sigma_rad = 0.00524;
  double cost_gate = 22.5;                 ///< on the optimised cost, χ² 6 d.o.f. 99.9 %
  int max_iterations = 5;
  double walk_position_m_per_sqrt_min = 0.0002;  ///< random walk between recalibrations (§5.6)
  double walk_rotation_rad_per_sqrt_min = 0.00035;
  double walk_beta_rad_per_sqrt_min = 0.000175;
};

enum class FusionOutcome { kFused, kFusedSecondSolution, kRejectedByGate, kIllConditioned, kNotFinite };

/// What a look did: sent, recorded and replayed as it is.
struct FusionReport {
  FusionOutcome outcome = FusionOutcome::kNotFinite;
  Vector6 innovation = Vector6::Zero();  ///< pose_error(measured, predicted before the update)
  double nis = 0.0;                      ///< innovation against H P Hᵀ + R, before the update
  double cost = 0.0;                     ///< optimised cost, what the gate judges
  double gain_norm = 0.0;
  int iterations = 0;
};

class JointOffsetEkf {
 public:
  JointOffsetEkf(const SerialChain& chain, const EkfOptions& options);

  /// Takes a model in force; P becomes the wide prior of the options.
  void reset(const LearnedModel& model);
  /// Takes a model with the covariance of [v; w; ε_β] that came with it.
  void reset(const LearnedModel& model, const StateMatrix& P);
  /// F = I (5.16): adds the random walk of dt_s to P.
  void predict(double dt_s);
  /// (5.12)–(5.15), iterated. Model and P are untouched unless the outcome is kFused or kFusedSecondSolution.
  FusionReport update(const HandPoseMeasurement& z);

  const LearnedModel& model() const { return model_; }
  const StateMatrix& covariance() const { return P_; }
  /// 6 × 6 covariance of the predicted hand pose in C at reading q: gauge-free.
  Matrix6 predicted_hand_covariance(const JointVector& q) const;

 private:
  SerialChain chain_;
  EkfOptions options_;
  LearnedModel model_;
  StateMatrix P_;
};

}  // namespace armsight
