#include "host/observability.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace armsight::host {
namespace {

using Kind = UnknownBlock::Kind;
constexpr double kRankTolerance = 1e-7;  // relative, calibration.md §3

struct ScaledSvd {
  Eigen::VectorXd scale;   // of the columns
  Eigen::VectorXd values;  // falling
  Eigen::MatrixXd V;       // right vectors of the scaled Jacobian
  int rank = 0;
};

ScaledSvd scaled_svd(const Eigen::MatrixXd& J) {
  ScaledSvd svd;
  svd.scale = J.colwise().norm().transpose();
  for (auto& s : svd.scale) s = s > 0.0 ? s : 1.0;
  const Eigen::MatrixXd scaled = J * svd.scale.cwiseInverse().asDiagonal();
  const Eigen::Index n = J.cols();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);  // of scaled = Q R: same singular values, small
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::Index rows = std::min(n, J.rows());
  R.topRows(rows) = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> small(R, Eigen::ComputeFullV);
  svd.values = small.singularValues();
  svd.V = small.matrixV();
  for (const double value : svd.values) svd.rank += value > kRankTolerance * svd.values[0] ? 1 : 0;
  return svd;
}

/// Preference as pivot: offsets first, scales, then rotations, then positions.
double pivot_weight(const UnknownBlock& block, int column) {
  if (block.kind == Kind::kOffset) return 1e6;
  if (block.kind == Kind::kScale) return 1e3;
  return column - block.column >= 3 ? 1.0 : 1e-3;
}

/// Reduces the basis (columns, unscaled) so that each vector alone has 1 at its pivot: null vectors people can read.
std::vector<int> reduce_to_pivots(const UnknownLayout& layout, Eigen::MatrixXd& N) {
  Eigen::VectorXd weight(layout.columns);
  for (const auto& block : layout.blocks) {
    for (int c = block.column; c < block.column + block.size; ++c) weight[c] = pivot_weight(block, c);
  }
  std::vector<int> pivots;
  for (Eigen::Index k = 0; k < N.cols(); ++k) {
    Eigen::Index row = 0, column = 0;
    (weight.asDiagonal() * N.rightCols(N.cols() - k)).cwiseAbs().maxCoeff(&row, &column);
    N.col(k).swap(N.col(k + column));
    N.col(k) /= N(row, k);
    for (Eigen::Index other = 0; other < N.cols(); ++other) {
      if (other != k) N.col(other) -= N(row, other) * N.col(k);
    }
    pivots.push_back(static_cast<int>(row));
  }
  return pivots;
}

/// A direction to two digits; of its two senses the one whose largest component is positive.
std::string axis_text(const Vector3& v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  const Vector3 u = v / (v[largest] > 0.0 ? v.norm() : -v.norm());
  const auto shown = [](double x) { return std::abs(x) < 0.005 ? 0.0 : x; };  // no "-0.00"
  char text[64];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f)", shown(u.x()), shown(u.y()), shown(u.z()));
  return text;
}

std::string part_in_words(const ChainModel& model, const UnknownBlock& block, const Eigen::VectorXd& null_vector) {
  const auto index = static_cast<std::size_t>(block.index);
  const double largest = null_vector.cwiseAbs().maxCoeff();
  if (block.kind == Kind::kOffset) {
    return std::abs(null_vector[block.column]) > 1e-4 * largest ? "the offset of " + model.offsets[index].name : "";
  }
  if (block.kind == Kind::kScale) {
    return std::abs(null_vector[block.column]) > 1e-4 * largest ? "the scale of " + model.targets[index].name : "";
  }
  if (block.kind != Kind::kCamera && block.kind != Kind::kMount) {
    if (null_vector.segment(block.column, block.size).norm() <= 1e-4 * largest) return "";
    if (block.kind == Kind::kAxis) return "where the axis of " + model.offsets[index].name + " lies";
    return block.kind == Kind::kTime ? "the looks' clock" : "the camera's intrinsics";
  }
  const std::string& name = block.kind == Kind::kCamera ? model.T_C_a.name : model.targets[index].T_b_M.name;
  const Vector3 v = null_vector.segment<3>(block.column), w = null_vector.segment<3>(block.column + 3);
  if (w.norm() > 1e-4 * largest) return "a turn of " + name + " about its axis " + axis_text(w);
  if (v.norm() > 1e-4 * largest) return "a shift of " + name + " along " + axis_text(v);
  return "";
}

std::string in_words(const ChainModel& model, const UnknownLayout& layout, const Eigen::VectorXd& null_vector) {
  std::vector<std::string> parts;
  for (const auto& block : layout.blocks) {
    const std::string part = part_in_words(model, block, null_vector);
    if (part.empty()) continue;
    parts.insert(block.kind == Kind::kOffset ? parts.begin() : parts.end(), part);
  }
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text + (parts.size() > 1 ? " cannot be told apart" : " cannot be seen");
}

const UnknownBlock& block_of(const UnknownLayout& layout, int column) {
  return *std::find_if(layout.blocks.begin(), layout.blocks.end(), [column](const UnknownBlock& block) {
    return column >= block.column && column < block.column + block.size;
  });
}

}  // namespace

Observability observe(const ChainModel& model, const std::vector<Observation>& observations,
                      const std::vector<char>& used, const NoiseModel& noise) {
  const UnknownLayout layout = unknown_layout(model);
  Observability result;
  result.parameters = layout.columns;
  if (layout.columns == 0) return result;
  const Eigen::MatrixXd J = whitened_jacobian(model, observations, used, noise, layout, false);
  const ScaledSvd svd = scaled_svd(J);
  result.rank = svd.rank;
  result.condition = svd.rank > 0 ? svd.values[0] / svd.values[svd.rank - 1] : 0.0;
  Eigen::MatrixXd N = svd.scale.cwiseInverse().asDiagonal() * svd.V.rightCols(layout.columns - svd.rank);
  result.pivot_columns = reduce_to_pivots(layout, N);
  for (Eigen::Index k = 0; k < N.cols(); ++k) {
    result.null_vectors.push_back(N.col(k));
    result.sentences.push_back(in_words(model, layout, N.col(k)));
  }
  return result;
}

std::vector<std::string> hold_unobservable_offsets(ChainModel& model, const std::vector<Observation>& observations,
                                                   const std::vector<char>& used, const NoiseModel& noise) {
  const Observability seen = observe(model, observations, used, noise);
  const UnknownLayout layout = unknown_layout(model);
  std::vector<std::string> held;
  for (std::size_t k = 0; k < seen.pivot_columns.size(); ++k) {
    const UnknownBlock& block = block_of(layout, seen.pivot_columns[k]);
    if (block.kind != Kind::kOffset) {
      held.push_back(seen.sentences[k]);
      continue;
    }
    ScalarUnknown& offset = model.offsets[static_cast<std::size_t>(block.index)];
    if (offset.freedom == Freedom::kFree) offset.freedom = Freedom::kFixed;
    char value[32];
    std::snprintf(value, sizeof value, "%.3g", offset.value);
    const bool by_prior = offset.freedom == Freedom::kPrior;
    held.push_back(seen.sentences[k] + "; " + offset.name + (by_prior ? " is held by its prior" : " is held at ") +
                   (by_prior ? "" : value));
  }
  return held;
}

Eigen::MatrixXd covariance_of(const ChainModel& model, const std::vector<Observation>& observations,
                              const std::vector<char>& used, const NoiseModel& noise) {
  const UnknownLayout layout = unknown_layout(model);
  const Eigen::MatrixXd J = whitened_jacobian(model, observations, used, noise, layout, true);
  const ScaledSvd svd = scaled_svd(J);
  const Eigen::Index n = layout.columns;
  if (svd.rank < n) {
    return Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity()).asDiagonal();
  }
  const Eigen::MatrixXd half = svd.scale.cwiseInverse().asDiagonal() * svd.V * svd.values.cwiseInverse().asDiagonal();
  return half * half.transpose();
}

}  // namespace armsight::host
