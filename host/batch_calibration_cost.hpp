// Ceres' view of host/chain_problem.hpp: poses as blocks of 7 (w, x, y, z, position) on their quaternion manifold, the
// other unknowns as they are, one analytic cost function a look. Included by batch_calibration_c*.cpp alone.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "host/look_weight.hpp"

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

/// The values that Ceres moves, one problem's worth: poses as 7 numbers, the rest as they are.
class UnknownValues {
 public:
  explicit UnknownValues(const ChainModel& model);
  double* of(const UnknownBlock& block) { return values_.at({block.kind, block.index}).data(); }
  void write_to(ChainModel& model) const;

 private:
  std::map<std::pair<UnknownBlock::Kind, int>, std::vector<double>> values_;
};
/// One block of numbers into the model.
void load_block(const UnknownBlock& block, const double* values, ChainModel& model);

/// W (z_measured − z_predicted) of one look. Blocks: those of look_unknowns, in their order.
class LookCost final : public ceres::CostFunction {
 public:
  /// `scratch` is written by Evaluate: one thread only.
  LookCost(ChainModel& scratch, const Observation& z, LookWeight W);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;
  std::vector<double*> blocks(UnknownValues& values) const;
  const LookUnknowns& columns() const { return columns_; }

 private:
  ChainModel& scratch_;
  const Observation& z_;
  LookWeight W_;
  LookUnknowns columns_;
};

}  // namespace armsight::host
