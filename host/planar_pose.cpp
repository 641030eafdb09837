#include "host/planar_pose.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace armsight::host {
namespace {

using Vector8 = Eigen::Matrix<double, 8, 1>;
using Jacobian8x6 = Eigen::Matrix<double, 8, 6>;

constexpr double kDistinct_rad = 1.0 * kDegree;

/// Corners without lens distortion, in pixels from the principal point: the error measure of this file.
Vector8 ideal_corners(const Corners& corners_px, const Intrinsics& k) {
  Vector8 z;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d xy = undistort(k, corners_px[static_cast<std::size_t>(i)]);
    z.segment<2>(2 * i) << k.fx * xy.x(), k.fy * xy.y();
  }
  return z;
}

/// Residual z − π(T p) and its derivative −∂π/∂[p; φ] for R ← exp(φ) R; false: a corner behind the camera.
bool linearise(const Pose& T, const std::array<Vector3, 4>& corners_M, const Vector8& z, const Intrinsics& k,
               Vector8& residual, Jacobian8x6& J) {
  for (int i = 0; i < 4; ++i) {
    const Vector3 turned = T.R * corners_M[static_cast<std::size_t>(i)];
    const Vector3 p = turned + T.p;
    if (!(p.z() > 1e-3)) return false;
    Eigen::Matrix<double, 2, 3> D;  // ∂π/∂p
    D << k.fx / p.z(), 0.0, -k.fx * p.x() / (p.z() * p.z()), 0.0, k.fy / p.z(), -k.fy * p.y() / (p.z() * p.z());
    residual.segment<2>(2 * i) = z.segment<2>(2 * i) - Eigen::Vector2d(k.fx * p.x() / p.z(), k.fy * p.y() / p.z());
    J.block<2, 3>(2 * i, 0) = D;
    J.block<2, 3>(2 * i, 3) = -D * skew(turned);
  }
  return true;
}

Pose moved(const Pose& T, const Vector6& step) { return {so3_exp(step.tail<3>()) * T.R, T.p + step.head<3>()}; }

std::optional<PlanarPose> polish(Pose T, const std::array<Vector3, 4>& corners_M, const Vector8& z, const Intrinsics& k,
                                 double sigma_px) {
  Vector8 residual, trial_residual;
  Jacobian8x6 J, trial_J;
  if (!linearise(T, corners_M, z, k, residual, J)) return std::nullopt;
  double lambda = 1e-3;
  for (int i = 0; i < 60; ++i) {
    Matrix6 N = J.transpose() * J;
    N.diagonal() *= 1.0 + lambda;
    const Vector6 step = N.ldlt().solve(J.transpose() * residual);
    const Pose trial = moved(T, step);
    const bool is_better = linearise(trial, corners_M, z, k, trial_residual, trial_J) &&
                           trial_residual.squaredNorm() <= residual.squaredNorm();
    lambda = is_better ? std::max(lambda * 0.2, 1e-12) : lambda * 8.0;
    if (is_better) {
      T = trial;
      residual = trial_residual;
      J = trial_J;
    }
    if (step.norm() < 1e-11 || lambda > 1e8) break;
  }
  const Eigen::LDLT<Matrix6> N(J.transpose() * J);
  PlanarPose pose{T, sigma_px * sigma_px * N.solve(Matrix6::Identity()), std::sqrt(residual.squaredNorm() / 8.0)};
  pose.covariance = 0.5 * (pose.covariance + pose.covariance.transpose()).eval();
  const bool faces_us = T.R.col(2).dot(T.p) < 0.0;
  if (!is_finite(T) || !pose.covariance.allFinite() || !faces_us) return std::nullopt;
  return pose;
}

std::vector<Pose> ippe_poses(const Vector8& z, double side_m, const Intrinsics& k) {
  const float h = static_cast<float>(side_m / 2.0);
  const std::vector<cv::Point3f> square = {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
  std::vector<cv::Point2d> image;
  for (int i = 0; i < 4; ++i) image.emplace_back(z[2 * i] / k.fx, z[2 * i + 1] / k.fy);
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(square, image, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE_SQUARE);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const auto vector = [](const cv::Mat& m) { return Vector3(m.at<double>(0), m.at<double>(1), m.at<double>(2)); };
    const Pose T{so3_exp(vector(rotations[i])), vector(translations[i])};
    if (is_finite(T) && T.p.z() > 0.0) poses.push_back(T);
  }
  return poses;
}

}  // namespace

std::array<Vector3, 4> marker_corners_M(double side_m) {
  const double h = side_m / 2.0;
  return {Vector3(-h, h, 0), Vector3(h, h, 0), Vector3(h, -h, 0), Vector3(-h, -h, 0)};
}

std::optional<PlanarPose> refine_planar_pose(const Pose& start_T_C_M, const Corners& corners_px, double side_m,
                                             const Intrinsics& intrinsics, double sigma_px) {
  return polish(start_T_C_M, marker_corners_M(side_m), ideal_corners(corners_px, intrinsics), intrinsics, sigma_px);
}

std::optional<PlanarSolutions> solve_planar_pose(const Corners& corners_px, double side_m, const Intrinsics& intrinsics,
                                                 double sigma_px) {
  const Vector8 z = ideal_corners(corners_px, intrinsics);
  if (!z.allFinite()) return std::nullopt;
  std::vector<PlanarPose> found;
  for (const Pose& start : ippe_poses(z, side_m, intrinsics)) {
    if (auto pose = polish(start, marker_corners_M(side_m), z, intrinsics, sigma_px)) found.push_back(*pose);
  }
  if (found.empty()) return std::nullopt;
  if (found.size() > 1 && found[1].rms_px < found[0].rms_px) std::swap(found[0], found[1]);
  PlanarSolutions solutions;
  solutions.best = found[0];
  // From near, both starts may end in one minimum: that is certainty, not ambiguity.
  if (found.size() > 1 && rotation_angle(found[0].T_C_M.R, found[1].T_C_M.R) > kDistinct_rad) {
    solutions.second = found[1];
    const double a = found[0].rms_px, b = found[1].rms_px;
    solutions.error_ratio = b / std::max(a, 1e-9);
    solutions.delta_chi2 = 8.0 * (b * b - a * a) / (sigma_px * sigma_px);
  }
  return solutions;
}

}  // namespace armsight::host
