// Wire messages ↔ our types, in the message's own frames; metres, radians, ns. from_wire refuses NaN, infinities,
// positions beyond 100 m, quaternions off unit length by more than 1e-3, covariances beyond 1e6 (m², rad²), times beyond
// 2^61 ns and wrong sizes; the text says which field and which rule. Quaternions are named: x, y, z, w in any order.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/arm_link.pb.h"
#include "shared/hand_eye.hpp"

namespace armsight {

/// Why a message was not taken.
struct Refused {
  wire::RefusalReason reason = wire::REFUSAL_REASON_UNSPECIFIED;
  std::string text;
};

/// 73 years either way: sums and differences of four such times fit an int64 (offsets and round trips of clocks).
inline constexpr std::int64_t kMaxWireTime_ns = (std::int64_t{1} << 61) - 1;
inline bool is_wire_time(std::int64_t ns) { return ns >= -kMaxWireTime_ns && ns <= kMaxWireTime_ns; }
[[nodiscard]] std::optional<Refused> check_time(std::int64_t ns, const char* field);

void to_wire(const Pose& T, wire::Pose* out);
/// Vectors, and matrices row by row.
template <typename Derived>
void to_wire(const Eigen::MatrixBase<Derived>& values, google::protobuf::RepeatedField<double>* out) {
  out->Clear();
  out->Reserve(static_cast<int>(values.size()));
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column) out->Add(values.derived().coeff(row, column));
}

/// nullopt: taken, `out` is set. Otherwise `out` is untouched. Positions within 100 m each way; the quaternion is
/// normalised where it has length 1 to 1e-3.
[[nodiscard]] std::optional<Refused> from_wire(const wire::Pose& in, const char* field, Pose& out);
[[nodiscard]] std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field,
                                               int expected_size, JointVector& out);
/// Square, row-major, symmetric to 1e-9 relative, non-negative diagonal, no entry beyond 1e6.
[[nodiscard]] std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field,
                                               int rows, StateMatrix& out);

}  // namespace armsight
