// Wire messages ↔ our types. from_wire refuses NaN, infinities, quaternions off unit length by more than 1e-3 and
// wrong sizes; the text says which field and which rule. Quaternions are named, their order is nowhere assumed.
#pragma once

#include <google/protobuf/repeated_field.h>

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

void to_wire(const Pose& T, wire::Pose* out);
/// Vectors, and matrices row by row.
template <typename Derived>
void to_wire(const Eigen::MatrixBase<Derived>& values, google::protobuf::RepeatedField<double>* out) {
  out->Clear();
  out->Reserve(static_cast<int>(values.size()));
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column) out->Add(values.derived().coeff(row, column));
}

/// nullopt: taken, `out` is set. Otherwise `out` is untouched.
[[nodiscard]] std::optional<Refused> from_wire(const wire::Pose& in, const char* field, Pose& out);
[[nodiscard]] std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field,
                                               int expected_size, JointVector& out);
/// Square, row-major, symmetric to 1e-9 relative, non-negative diagonal.
[[nodiscard]] std::optional<Refused> from_wire(const google::protobuf::RepeatedField<double>& in, const char* field,
                                               int rows, StateMatrix& out);

}  // namespace armsight
