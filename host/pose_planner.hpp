// Which postures should the arm take so that the looks tell most? Candidates are spread evenly over the joints' range
// (a Halton sequence: same input, same plan), kept where the camera would see the marker well under the current model,
// chosen for the largest determinant of the information (D-optimal, greedy with exchange), and ordered for short
// travel. All angles real (reading + beta), rad. Pure. specification F-C6, §5.3.
#pragma once

#include <vector>

#include "host/visibility.hpp"
#include "shared/collision.hpp"

namespace armsight::host {

/// The i-th point of an even, fixed sequence over the box [min, max] (i from 0).
JointVector spread_posture(const JointVector& min_rad, const JointVector& max_rad, int i);

/// The i-th of postures spread over the box of ± reach_rad about q, cut to [min, max].
JointVector posture_near(const JointVector& q, double reach_rad, const JointVector& min_rad, const JointVector& max_rad,
                         int i);

struct PlanProblem {
  SerialChain chain;
  JointVector min_rad, max_rad;  ///< of real angles, safety margin already taken off
  Pose T_C_B;                    ///< as believed now
  Pose T_H_M;
  PinholeView view;
  ViewLimits limits;
  double marker_side_m = 0.05;
  LookNoise noise;
  std::vector<Vector3> hidden;   ///< where the marker should have been and was not, in C: something is in the way
  CollisionModel collision;      ///< what is too near to something is not planned
  StateMatrix P;                 ///< covariance of [v; w; ε_β] now; widens the image margin where the model is unsure
};

struct CandidateLook {
  JointVector q_real;
  StateMatrix information;
};

/// Nearer to something than the controller allows?
bool is_too_near(const PlanProblem& problem, const JointVector& q_real);

/// Visible postures, at most `wanted`. `unsure_sigmas`: so many standard deviations of the predicted marker pose must
/// stay inside the view limits too. None nearer than `min_distance_rad` (largest joint difference) to one of `avoid`.
std::vector<CandidateLook> visible_postures(const PlanProblem& problem, int wanted, double unsure_sigmas,
                                            const std::vector<JointVector>& avoid, double min_distance_rad = 0.15);

/// Indices of the `count` candidates that maximise log det(prior + Σ information), most informative first.
std::vector<int> choose_d_optimal(const std::vector<CandidateLook>& candidates, const StateMatrix& prior_information,
                                  int count);

/// log det(prior + Σ of the chosen): what choose_d_optimal maximises.
double log_det_information(const std::vector<CandidateLook>& candidates, const StateMatrix& prior_information,
                           const std::vector<int>& chosen);

/// The same indices in the order of a short tour from q_start (nearest next; distance = largest joint travel).
std::vector<int> order_by_travel(const std::vector<CandidateLook>& candidates, std::vector<int> chosen,
                                 const JointVector& q_start);

/// The whole plan: candidates (fewer sigmas where too few are left), choice, and order if wanted. May be shorter than
/// count, empty where nothing is visible.
std::vector<JointVector> plan_looks(const PlanProblem& problem, int count, const std::vector<JointVector>& avoid,
                                    const JointVector& q_start, bool shorten_travel);

}  // namespace armsight::host
