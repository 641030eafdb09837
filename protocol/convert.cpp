#include "protocol/convert.hpp"

#include <algorithm>
#include <cmath>

namespace armsight {

namespace {

constexpr double kMaxDistance_m = 100.0;    // no arm is that large; squares of what passes stay finite
constexpr double kMaxCovariance = 1e6;      // m² or rad²
constexpr double kQuaternionTolerance = 1e-3;  // controller.md §8.3
constexpr double kSymmetryTolerance = 1e-9;

Refused refuse(wire::RefusalReason reason, const char* field, const std::string& rule) {
  return {reason, std::string(field) + ": " + rule};
}

std::optional<Refused> check_finite_and_size(const google::protobuf::RepeatedField<double>& in, const char* field,
                                             int size) {
  if (in.size() != size)
    return refuse(wire::REFUSAL_REASON_MALFORMED, field,
                  "has " + std::to_string(in.size()) + " values, must have " + std::to_string(size));
  if (!std::all_of(in.begin(), in.end(), [](double v) { return std::isfinite(v); }))
    return refuse(wire::REFUSAL_REASON_NOT_FINITE, field, "must be finite");
  return std::nullopt;
}

}  // namespace

std::optional<Refused> check_time(std::int64_t ns, const char* field) {
  if (is_wire_time(ns)) return std::nullopt;
  return refuse(wire::REFUSAL_REASON_MALFORMED, field, "must be within 2^61 ns of zero");
}

void to_wire(const Pose& T, wire::Pose* out) {
  Eigen::Quaterniond quat(T.R);
  if (quat.w() < 0) quat.coeffs() = -quat.coeffs();  // one of the two: equal poses are equal bytes
  out->set_x_m(T.p.x());
  out->set_y_m(T.p.y());
  out->set_z_m(T.p.z());
  out->set_qw(quat.w());
  out->set_qx(quat.x());
  out->set_qy(quat.y());
  out->set_qz(quat.z());
}

std::optional<Refused> from_wire(const wire::Pose& in, const char* field, Pose& out) {
  const Vector3 p_m(in.x_m(), in.y_m(), in.z_m());
  const Eigen::Quaterniond quat(in.qw(), in.qx(), in.qy(), in.qz());
  if (!p_m.allFinite() || !quat.coeffs().allFinite())
    return refuse(wire::REFUSAL_REASON_NOT_FINITE, field, "must be finite");
  if (p_m.cwiseAbs().maxCoeff() > kMaxDistance_m)
    return refuse(wire::REFUSAL_REASON_OUT_OF_LIMITS, field, "position must be within 100 m");
  const double length = quat.coeffs().stableNorm();
  if (std::abs(length - 1.0) > kQuaternionTolerance)
    return refuse(wire::REFUSAL_REASON_BAD_QUATERNION, field,
                  "quaternion has length " + std::to_string(length) + ", must be 1 to 0.001");
  out = {quat.normalized().toRotationMatrix(), p_m};
  return std::nullopt;
}

std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field,
                                 int expected_size, JointVector& out) {
  if (auto refused = check_finite_and_size(in, field, expected_size)) return refused;
  out = Eigen::Map<const Eigen::VectorXd>(in.data(), in.size());
  return std::nullopt;
}

std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field, int rows,
                                 StateMatrix& out) {
  if (auto refused = check_finite_and_size(in, field, rows * rows)) return refused;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> P(in.data(), rows, rows);
  const double largest = rows == 0 ? 0.0 : P.cwiseAbs().maxCoeff();
  if (largest > kMaxCovariance) return refuse(wire::REFUSAL_REASON_IMPLAUSIBLE, field, "covariance beyond 1e6");
  if (rows > 0 && (P - P.transpose()).cwiseAbs().maxCoeff() > kSymmetryTolerance * largest)
    return refuse(wire::REFUSAL_REASON_IMPLAUSIBLE, field, "must be symmetric");
  if ((P.diagonal().array() < 0.0).any())
    return refuse(wire::REFUSAL_REASON_IMPLAUSIBLE, field, "variances must not be negative");
  out = 0.5 * (P + P.transpose());
  return std::nullopt;
}

}  // namespace armsight
