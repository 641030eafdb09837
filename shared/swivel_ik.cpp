#include "shared/swivel_ik.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace armsight {
namespace {

constexpr double kAtLimit_rad = 1e-7;      // a root of a limit's equation may lie beyond it by its rounding
constexpr double kDegenerate = 1e-9;       // sine below which two directions are one
constexpr double kSameTrace = 1e-10;       // 1e-5 rad beside a goal that is met
constexpr double kTurn = 2.0 * std::numbers::pi;

Vector3 turned(const Vector3& axis, double c, double s, const Vector3& v) {
  return c * v + s * axis.cross(v) + (1.0 - c) * axis.dot(v) * axis;
}

/// The angle about `axis` from the half-plane of `from` to that of `to`; nullopt where one of them lies on the axis.
std::optional<double> angle_about(const Vector3& axis, const Vector3& from, const Vector3& to) {
  const double s = axis.dot(from.cross(to));
  const double c = from.dot(to) - axis.dot(from) * axis.dot(to);
  if (std::hypot(s, c) < kDegenerate) return std::nullopt;
  return std::atan2(s, c);
}

/// `angle` plus whole turns: inside [min, max], nearest to `seed`; clamped when beyond by rounding; nullopt outside.
std::optional<double> within(double angle, double min, double max, double seed) {
  angle += kTurn * std::round((seed - angle) / kTurn);
  if (angle > max + kAtLimit_rad) angle -= kTurn * std::ceil((angle - max - kAtLimit_rad) / kTurn);
  if (angle < min - kAtLimit_rad) angle += kTurn * std::ceil((min - kAtLimit_rad - angle) / kTurn);
  if (angle > max + kAtLimit_rad || angle < min - kAtLimit_rad) return std::nullopt;
  return std::clamp(angle, min, max);
}

/// As within, but the limit nearest to it where the angle lies outside.
double nearest_within(double angle, double min, double max, double seed) {
  if (const auto inside = within(angle, min, max, seed)) return *inside;
  const double middle = 0.5 * (min + max);
  return std::clamp(angle + kTurn * std::round((middle - angle) / kTurn), min, max);
}

/// One elbow: what the swivel leaves of the arm, with the hand in its place.
struct Elbow {
  double q4;
  Vector3 axis;         ///< shoulder → hand
  Matrix3 R_shoulder;   ///< turn of joints 1 to 3 at ψ = 0
  Matrix3 K;            ///< trace(R_goalᵀ R) = [1 cos ψ sin ψ] K [1 cos q5 sin q5]ᵀ
};

class Search {
 public:
  Search(const SwivelArm& arm, const JointVector& min_rad, const JointVector& max_rad, const Pose& T_B_G,
         const JointVector& seed, double tolerance_m)
      : arm_(arm), min_(min_rad), max_(max_rad), goal_(T_B_G), seed_(seed), tolerance_m_(tolerance_m) {}

  std::optional<JointVector> run() {
    find_elbows();
    for (int i = 0; i < elbow_count_; ++i) try_free(elbow_[static_cast<std::size_t>(i)]);
    // The free optimum is the best there is: only where the limits forbid it, their edges are looked at.
    if (!best_)
      for (int i = 0; i < elbow_count_; ++i) try_edges(elbow_[static_cast<std::size_t>(i)]);
    return best_;
  }

  int tried() const { return tried_; }

 private:
  void find_elbows() {
    const double a = arm_.upper_arm_m, b = arm_.forearm_m, distance = (goal_.p - arm_.shoulder).norm();
    const double cosine = (distance * distance - a * a - b * b) / (2.0 * a * b);
    const double elbow = std::acos(std::clamp(cosine, -1.0, 1.0));
    for (const double tolerance : {1e-3 * tolerance_m_, tolerance_m_}) {  // as exact as the limits let it
      add_elbow(elbow, distance, tolerance);
      if (elbow > 0.0 && elbow < std::numbers::pi) add_elbow(-elbow, distance, tolerance);
      if (elbow_count_ > 0) return;
    }
  }

  void add_elbow(double angle, double distance, double tolerance_m) {
    // Near a stretched arm a small step beyond a limit costs next to nothing: the limit is tried.
    const double q4 = nearest_within(angle - arm_.elbow_at_zero_rad, min_[3], max_[3], seed_[3]);
    const double bend = q4 + arm_.elbow_at_zero_rad;
    const double x = arm_.upper_arm_m + arm_.forearm_m * std::cos(bend), y = arm_.forearm_m * std::sin(bend);
    const double error = std::abs(std::hypot(x, y) - distance);
    if (!(error <= tolerance_m) || std::hypot(x, y) < kDegenerate || distance < kDegenerate) return;

    Elbow& elbow = elbow_[static_cast<std::size_t>(elbow_count_++)];
    elbow.q4 = q4;
    elbow.axis = (goal_.p - arm_.shoulder) / distance;
    // ψ = 0: the plane of shoulder, elbow and hand through a fixed direction; (axis, across, normal) is right-handed.
    Eigen::Index least = 0;
    elbow.axis.cwiseAbs().minCoeff(&least);
    const Vector3 normal = elbow.axis.cross(Vector3::Unit(least)).normalized();
    const double length = std::hypot(x, y);
    const Vector3 upper = (x / length) * elbow.axis - (y / length) * normal.cross(elbow.axis);
    Matrix3 now, zero;
    now << upper, normal, upper.cross(normal);
    zero << arm_.upper_arm, arm_.axis[3], arm_.upper_arm.cross(arm_.axis[3]);
    elbow.R_shoulder = now * zero.transpose();
    elbow.K = trace_form(elbow);
  }

  Matrix3 trace_form(const Elbow& elbow) const {
    const Matrix3 G = elbow.R_shoulder * so3_exp(elbow.q4 * arm_.axis[3]);
    const Matrix3 W = arm_.R_B_H * goal_.R.transpose();
    const auto parts = [](const Vector3& n) {
      const Matrix3 along = n * n.transpose();
      return std::array<Matrix3, 3>{along, Matrix3::Identity() - along, skew(n)};
    };
    const auto X = parts(elbow.axis), Y = parts(arm_.axis[4]);
    Matrix3 K;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const Matrix3 M = G * Y[static_cast<std::size_t>(j)] * W;
      for (Eigen::Index i = 0; i < 3; ++i) K(i, j) = X[static_cast<std::size_t>(i)].cwiseProduct(M.transpose()).sum();
    }
    return K;
  }

  /// The free optimum: the forearm turned into the plane of the axis and the goal's own forearm. Where one of them lies
  /// on the axis every swivel is as good, and the seed's is taken.
  void try_free(const Elbow& elbow) {
    const Vector3 forearm = elbow.R_shoulder * (so3_exp(elbow.q4 * arm_.axis[3]) * arm_.axis[4]);
    const Vector3 wanted = goal_.R * (arm_.R_B_H.transpose() * arm_.axis[4]);
    const std::optional<double> swivel = angle_about(elbow.axis, forearm, wanted);
    try_swivel(elbow, swivel ? *swivel : swivel_of_seed(elbow), Edges::kExcluded);
  }

  /// Every edge of the limits has one best point: q5 at a limit, or joint 1, 2 or 3 at one (both roots).
  void try_edges(const Elbow& elbow) {
    const Vector3 &a1 = arm_.axis[0], &a2 = arm_.axis[1], &a3 = arm_.axis[2];
    const Vector3 v = elbow.R_shoulder * a3;
    try_swivel(elbow, swivel_of_seed(elbow), Edges::kIncluded);
    for (const double limit : {min_[4], max_[4]}) {
      const Vector3 row = elbow.K * Vector3(1.0, std::cos(limit), std::sin(limit));
      try_swivel(elbow, std::atan2(row[2], row[1]), Edges::kIncluded);
    }
    for (const JointVector* limits : {&min_, &max_}) {
      const JointVector& q = *limits;
      try_roots(elbow, so3_exp(q[0] * a1) * a2, v, 0.0);                 // R123 a3 lies in joint 2's plane
      try_roots(elbow, a1, v, a1.dot(so3_exp(q[1] * a2) * a3));          // a1 sees a3 under a fixed angle
      try_roots(elbow, a1, elbow.R_shoulder * (so3_exp(-q[2] * a3) * a2), 0.0);  // joint 2's axis is ⟂ a1
    }
  }

  /// Both ψ with x · exp(ψ axis) y = value.
  void try_roots(const Elbow& elbow, const Vector3& x, const Vector3& y, double value) {
    const double constant = x.dot(elbow.axis) * elbow.axis.dot(y);
    const double c = x.dot(y) - constant, s = x.dot(elbow.axis.cross(y)), r = std::hypot(c, s);
    if (r < kDegenerate || std::abs(value - constant) > r * (1.0 + kDegenerate)) return;
    const double middle = std::atan2(s, c), half = std::acos(std::clamp((value - constant) / r, -1.0, 1.0));
    try_swivel(elbow, middle + half, Edges::kIncluded);
    try_swivel(elbow, middle - half, Edges::kIncluded);
  }

  enum class Edges { kExcluded, kIncluded };
  struct Roll {
    double q5, trace;
    bool is_at_limit;
  };

  double swivel_of_seed(const Elbow& elbow) const {
    const Matrix3 R =
        so3_exp(seed_[0] * arm_.axis[0]) * so3_exp(seed_[1] * arm_.axis[1]) * so3_exp(seed_[2] * arm_.axis[2]);
    return angle_about(elbow.axis, elbow.R_shoulder * arm_.axis[3], R * arm_.axis[3]).value_or(0.0);
  }

  /// The best q5 within its limits for a swivel.
  Roll best_roll(const Elbow& elbow, double psi) const {
    const Eigen::RowVector3d m = Eigen::RowVector3d(1.0, std::cos(psi), std::sin(psi)) * elbow.K;
    const auto trace_at = [&](double q5) { return m[0] + m[1] * std::cos(q5) + m[2] * std::sin(q5); };
    const double amplitude = std::hypot(m[1], m[2]);
    const double best = amplitude < kDegenerate ? seed_[4] : std::atan2(m[2], m[1]);
    if (const auto q5 = within(best, min_[4], max_[4], seed_[4])) return {*q5, trace_at(*q5), false};
    const double low = trace_at(min_[4]), high = trace_at(max_[4]);
    return low > high ? Roll{min_[4], low, true} : Roll{max_[4], high, true};
  }

  /// The postures of both shoulder branches at this swivel.
  void try_swivel(const Elbow& elbow, double psi, Edges edges) {
    const Roll roll = best_roll(elbow, psi);
    const double c = std::cos(psi), s = std::sin(psi);
    if (roll.is_at_limit && edges == Edges::kExcluded) return;
    Matrix3 R;
    for (Eigen::Index i = 0; i < 3; ++i) R.col(i) = turned(elbow.axis, c, s, elbow.R_shoulder.col(i));
    const Vector3 v = R * arm_.axis[2];
    const Vector3 &a1 = arm_.axis[0], &a2 = arm_.axis[1], &a3 = arm_.axis[2];
    const double middle = std::atan2(a1.dot(a2.cross(a3)), a1.dot(a3));
    const double half = std::atan2(a1.cross(v).norm(), a1.dot(v));
    for (const double sign : {1.0, -1.0}) try_posture(elbow, roll, R, middle + sign * half);
  }

  void try_posture(const Elbow& elbow, const Roll& roll, const Matrix3& R, double q2) {
    ++tried_;
    const Vector3 &a1 = arm_.axis[0], &a2 = arm_.axis[1], &a3 = arm_.axis[2];
    JointVector q(5);
    const auto second = within(q2, min_[1], max_[1], seed_[1]);
    if (!second) return;
    q[1] = *second;
    // Upper arm along axis 1: joints 1 and 3 turn about one line, and joint 1 stays where it is.
    const Vector3 w = turned(a2, std::cos(q[1]), std::sin(q[1]), a3);
    const auto first = within(angle_about(a1, w, R * a3).value_or(seed_[0]), min_[0], max_[0], seed_[0]);
    if (!first) return;
    q[0] = *first;
    const Vector3 m = turned(a2, std::cos(q[1]), -std::sin(q[1]), turned(a1, std::cos(q[0]), -std::sin(q[0]), R * a2));
    const auto third = within(std::atan2(a3.dot(a2.cross(m)), a2.dot(m)), min_[2], max_[2], seed_[2]);
    if (!third) return;
    q[2] = *third;
    q[3] = elbow.q4;
    q[4] = roll.q5;
    keep_better(q, roll.trace);
  }

  /// Larger trace, hence less orientation error; among equals the nearer to the seed.
  void keep_better(const JointVector& q, double trace) {
    if (best_ && trace < best_trace_ - kSameTrace) return;
    const bool is_equal = best_ && trace <= best_trace_ + kSameTrace;
    if (is_equal && (q - seed_).squaredNorm() >= (*best_ - seed_).squaredNorm()) return;
    best_ = q;
    best_trace_ = trace;
  }

  const SwivelArm& arm_;
  const JointVector &min_, &max_;
  const Pose& goal_;
  const JointVector& seed_;
  double tolerance_m_;
  std::array<Elbow, 2> elbow_;
  int elbow_count_ = 0;
  int tried_ = 0;
  std::optional<JointVector> best_;
  double best_trace_ = 0.0;
};

}  // namespace

std::optional<IkSolution> solve_swivel_ik(const SerialChain& chain, const SwivelArm& arm, const JointVector& min_rad,
                                          const JointVector& max_rad, const Pose& T_B_G, const JointVector& seed,
                                          double position_tolerance_m) {
  Search search(arm, min_rad, max_rad, T_B_G, seed, position_tolerance_m);
  const std::optional<JointVector> q = search.run();
  if (!q) return std::nullopt;
  const Vector6 e = pose_error(T_B_G, forward_kinematics(chain, *q));
  if (!(e.head<3>().norm() <= position_tolerance_m)) return std::nullopt;
  return IkSolution{*q, e.head<3>().norm(), e.tail<3>().norm(), search.tried()};
}

}  // namespace armsight
