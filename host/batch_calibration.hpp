// Learn: robust maximum likelihood for the problem of host/chain_problem.hpp, (4.5)–(4.7) whitened as in
// specification §5.4, by Levenberg-Marquardt on the normal equations; one thread, deterministic.
// Several starts are scored by their robust cost, the best are refined, the loss follows the residuals' own spread,
// gross outliers leave with a reason, and a look's second planar solution is taken where it fits better.
#pragma once

#include <string>
#include <vector>

#include "host/look_weight.hpp"

namespace armsight::host {

enum class RobustLoss { kNone, kHuber, kCauchy };

/// What is made small.
enum class LearnCost {
  kLikelihood,  ///< corners where there are any, else poses by their covariance; encoders and floor with both (default)
  kPoses,       ///< corners only as the pose they give, with its covariance
  kPixels,      ///< reprojection, every corner alike, no loss: what most tools do; poses as in kLikelihood
  kThesis,      ///< (4.6) as printed: metres and half-angle sines unweighted, no loss
};
/// The looks as this cost sees them.
std::vector<Observation> observations_for(LearnCost cost, const ChainModel& model,
                                          const std::vector<Observation>& observations);

struct BatchOptions {
  NoiseModel noise;
  bool estimates_noise = false;     ///< the residuals set floor and σ_px, round by round; `noise` is where they begin
  RobustLoss loss = RobustLoss::kCauchy;
  double loss_per_median = 2.0;     ///< width of the loss over the median whitened residual norm of a look ...
  double outlier_per_median = 5.0;  ///< ... and the norm from which a look is left out
  int refined_starts = 3;
  int rounds = 3;                   ///< reweighting rounds
  int max_iterations = 60;          ///< Levenberg-Marquardt steps a round
};

struct LookFit {
  bool used = true;
  bool second_solution = false;
  double norm = 0.0;    ///< ‖W r‖ / sqrt(rows): 1 where the noise model is right
  std::string reason;   ///< why it is left out
};

struct BatchSolution {
  ChainModel model;
  std::vector<LookFit> looks;
  std::vector<char> used;            ///< looks[i].used, as whitened_jacobian wants it
  std::vector<Observation> observations;  ///< with the second solutions swapped in, and the σ_px found
  NoiseModel noise;                  ///< as given, or as found
  double misfit = 0.0;               ///< rms of norm over the used looks
  int iterations = 0;
  bool converged = false;
};

/// Throws std::invalid_argument for no start or no observation.
BatchSolution solve_batch(const std::vector<ChainModel>& starts, const std::vector<Observation>& observations,
                          const BatchOptions& options);

/// Σ log(1 + norm²/9) over the looks at this model: small is good, outliers count little.
double robust_score(const ChainModel& model, const std::vector<Observation>& observations, const NoiseModel& noise);

/// Largest relative disagreement, block by block, between the analytic Jacobians and Ceres' numeric ones.
double jacobian_disagreement(const ChainModel& model, const std::vector<Observation>& observations,
                             const NoiseModel& noise);

}  // namespace armsight::host
