#include "host/closed_form_starts.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <opencv2/calib3d.hpp>

namespace armsight::host {
namespace {

using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;

Pose mean_of(const std::vector<Pose>& poses, const std::vector<std::size_t>& kept) {
  Matrix3 sum_R = Matrix3::Zero();
  Vector3 sum_p = Vector3::Zero();
  for (const std::size_t i : kept) {
    sum_R += poses[i].R;
    sum_p += poses[i].p;
  }
  return {nearest_rotation(sum_R), sum_p / static_cast<double>(kept.size())};
}

/// Indices of the 70 % of `poses` nearest to `centre`, 0.1 m weighing as much as 0.5 rad.
std::vector<std::size_t> inner_part(const std::vector<Pose>& poses, const Pose& centre) {
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double distance = (poses[i].p - centre.p).norm() / 0.1 + rotation_angle(poses[i].R, centre.R) / 0.5;
    by_distance.emplace_back(distance, i);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::size_t> kept;
  const std::size_t count = std::max<std::size_t>(1, poses.size() * 7 / 10);
  for (std::size_t k = 0; k < count; ++k) kept.push_back(by_distance[k].second);
  return kept;
}

cv::Mat to_cv(const Matrix3& R) {
  cv::Mat m(3, 3, CV_64F);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m.at<double>(r, c) = R(r, c);
  }
  return m;
}
cv::Mat to_cv(const Vector3& p) { return (cv::Mat_<double>(3, 1) << p.x(), p.y(), p.z()); }

struct CvPoses {
  std::vector<cv::Mat> R, t;
  void add(const Pose& T) {
    R.push_back(to_cv(T.R));
    t.push_back(to_cv(T.p));
  }
};

/// Adds the pose when it is one: OpenCV's methods also answer with nonsense and NaN.
void add_if_pose(const cv::Mat& R, const cv::Mat& t, bool inverse, std::vector<Pose>& poses) {
  if (R.total() != 9 || t.total() != 3) return;
  Pose T;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) T.R(r, c) = R.at<double>(r, c);
    T.p[r] = t.at<double>(r);
  }
  if (!is_finite(T) || !is_rotation(T.R, 0.2)) return;
  T.R = nearest_rotation(T.R);
  poses.push_back(inverse ? T.inverse() : T);
}

void add_opencv(const std::vector<Pose>& T_C_M, const std::vector<Pose>& G, std::vector<Pose>& candidates) {
  CvPoses measured, chain, chain_inverse;
  for (std::size_t i = 0; i < G.size(); ++i) {
    measured.add(T_C_M[i]);
    chain.add(G[i]);
    chain_inverse.add(G[i].inverse());
  }
  try {
    cv::Mat R_V, t_V, R, t;
    cv::calibrateRobotWorldHandEye(measured.R, measured.t, chain.R, chain.t, R_V, t_V, R, t,
                                   cv::CALIB_ROBOT_WORLD_HAND_EYE_SHAH);
    add_if_pose(R, t, false, candidates);
    for (const auto method : {cv::CALIB_HAND_EYE_PARK, cv::CALIB_HAND_EYE_HORAUD, cv::CALIB_HAND_EYE_DANIILIDIS}) {
      cv::calibrateHandEye(chain_inverse.R, chain_inverse.t, measured.R, measured.t, R, t, method);
      add_if_pose(R, t, true, candidates);
    }
  } catch (const cv::Exception&) {
    return;  // a set it cannot take: our own start and the given one remain
  }
}

struct TargetPairs {
  std::vector<Pose> T_C_M, G;
};

std::vector<TargetPairs> pairs_by_target(const ChainModel& model, const std::vector<Observation>& observations) {
  std::vector<TargetPairs> pairs(model.targets.size());
  for (const auto& z : observations) {
    Pose T_C_M = z.T_C_M;
    T_C_M.p *= model.targets[static_cast<std::size_t>(z.target)].scale.value;
    pairs[static_cast<std::size_t>(z.target)].T_C_M.push_back(T_C_M);
    pairs[static_cast<std::size_t>(z.target)].G.push_back(chain_between(model, z));
  }
  return pairs;
}

std::vector<Pose> thinned(const std::vector<Pose>& poses) {
  const std::size_t step = poses.size() / 60 + 1;  // PARK and its kin look at all pairs
  std::vector<Pose> some;
  for (std::size_t i = 0; i < poses.size(); i += step) some.push_back(poses[i]);
  return some;
}

void add_camera_candidates(const ChainModel& model, const std::vector<TargetPairs>& pairs, std::vector<Pose>& X) {
  for (std::size_t t = 0; t < pairs.size(); ++t) {
    const PoseUnknown& mount = model.targets[t].T_b_M;
    if (pairs[t].G.empty()) continue;
    if (mount.freedom == Freedom::kFixed || X.size() == 1) {
      std::vector<Pose> each;
      for (std::size_t i = 0; i < pairs[t].G.size(); ++i) {
        each.push_back(pairs[t].T_C_M[i] * (pairs[t].G[i] * mount.value).inverse());
      }
      X.push_back(robust_mean(each));
    }
    if (mount.freedom == Freedom::kFixed || pairs[t].G.size() < 3) continue;
    X.push_back(linear_robot_world(pairs[t].T_C_M, pairs[t].G));
    add_opencv(thinned(pairs[t].T_C_M), thinned(pairs[t].G), X);
  }
}

}  // namespace

Pose robust_mean(const std::vector<Pose>& poses) {
  std::vector<std::size_t> kept(poses.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  Pose mean = mean_of(poses, kept);
  for (int round = 0; round < 5; ++round) mean = mean_of(poses, inner_part(poses, mean));
  return mean;
}

Pose linear_robot_world(const std::vector<Pose>& T_C_M, const std::vector<Pose>& G) {
  Matrix18 normal = Matrix18::Zero();  // of (I ⊗ R_T) vec R_V − (R_Gᵀ ⊗ I) vec R_X = 0
  for (std::size_t i = 0; i < G.size(); ++i) {
    Eigen::Matrix<double, 9, 18> rows = Eigen::Matrix<double, 9, 18>::Zero();
    for (int c = 0; c < 3; ++c) {
      rows.block<3, 3>(3 * c, 3 * c) = T_C_M[i].R;
      for (int k = 0; k < 3; ++k) rows.block<3, 3>(3 * c, 9 + 3 * k) = -G[i].R(k, c) * Matrix3::Identity();
    }
    normal += rows.transpose() * rows;
  }
  const Vector18 solution = Eigen::SelfAdjointEigenSolver<Matrix18>(normal).eigenvectors().col(0);
  Matrix3 M = Eigen::Map<const Matrix3>(solution.data() + 9);
  if (M.determinant() < 0.0) M = -M;
  const Matrix3 R_X = nearest_rotation(M);

  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity() * 1e-9;  // sets that do not turn
  Vector6 b = Vector6::Zero();
  for (std::size_t i = 0; i < G.size(); ++i) {
    Eigen::Matrix<double, 3, 6> row;
    row << T_C_M[i].R, -Matrix3::Identity();  // R_T p_V − p_X = R_X p_G − p_T
    A += row.transpose() * row;
    b += row.transpose() * (R_X * G[i].p - T_C_M[i].p);
  }
  const Vector6 p = A.ldlt().solve(b);
  return {R_X, p.tail<3>()};
}

std::vector<ChainModel> closed_form_starts(const ChainModel& model, const std::vector<Observation>& observations) {
  const auto pairs = pairs_by_target(model, observations);
  std::vector<Pose> X{model.T_C_a.value};
  if (model.T_C_a.freedom != Freedom::kFixed) add_camera_candidates(model, pairs, X);
  std::vector<ChainModel> starts{model};
  for (const Pose& T_C_a : X) {
    ChainModel start = model;
    start.T_C_a.value = T_C_a;
    for (std::size_t t = 0; t < pairs.size(); ++t) {
      if (model.targets[t].T_b_M.freedom == Freedom::kFixed || pairs[t].G.empty()) continue;
      std::vector<Pose> each;
      for (std::size_t i = 0; i < pairs[t].G.size(); ++i) {
        each.push_back((T_C_a * pairs[t].G[i]).inverse() * pairs[t].T_C_M[i]);
      }
      start.targets[t].T_b_M.value = robust_mean(each);
    }
    starts.push_back(start);
  }
  return starts;
}

}  // namespace armsight::host
