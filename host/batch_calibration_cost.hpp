// Ceres' view of host/chain_problem.hpp: poses as blocks of 7 (w, x, y, z, position) on their manifold, offsets and
// scales as blocks of 1, one analytic cost function a look. Included by batch_calibration*.cpp alone.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <array>
#include <vector>

#include "host/chain_problem.hpp"

namespace armsight::host {

using PoseBlock = std::array<double, 7>;
PoseBlock to_block(const Pose& pose);
Pose from_block(const double* block);

/// Which side the step multiplies from: T_C_a on the right (frame a), T_b_M on the left (frame b).
enum class StepSide { kRight, kLeft };

class PoseManifold final : public ceres::Manifold {
 public:
  explicit PoseManifold(StepSide side) : side_(side) {}
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  StepSide side_;
};

/// The values that Ceres moves, one problem's worth.
struct UnknownValues {
  explicit UnknownValues(const ChainModel& model);
  void write_to(ChainModel& model) const;

  PoseBlock camera;
  std::vector<PoseBlock> mounts;
  std::vector<double> offsets, scales;
};

/// W (z_measured − z_predicted) of one look. Blocks: camera, mount, involved offsets, scale.
class LookCost final : public ceres::CostFunction {
 public:
  /// `scratch` is written by Evaluate: one thread only.
  LookCost(ChainModel& scratch, const Observation& z, Eigen::MatrixXd W);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;
  std::vector<double*> blocks(UnknownValues& values) const;

 private:
  void load(double const* const* parameters) const;
  ChainModel& scratch_;
  const Observation& z_;
  Eigen::MatrixXd W_;
  std::vector<int> involved_;
};

/// (value − prior) / sigma of a pose, in the step's own tangent.
class PosePriorCost final : public ceres::SizedCostFunction<6, 7> {
 public:
  PosePriorCost(const PoseUnknown& unknown, StepSide side) : unknown_(unknown), side_(side) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  PoseUnknown unknown_;
  StepSide side_;
};

class ScalarPriorCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  ScalarPriorCost(double prior, double sigma) : prior_(prior), sigma_(sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  double prior_, sigma_;
};

}  // namespace armsight::host
