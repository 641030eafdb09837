// From the ways people describe an arm to our SerialChain: joints with an origin and any axis (URDF), or DH rows.
// Our joints turn about z; an axis elsewhere is brought there by a fixed rotation put before and undone after the turn.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/arm_model.hpp"

namespace armsight::host {

/// A joint as URDF has it: its frame in the previous link, then a turn about `axis` of that frame.
struct DescribedJoint {
  std::string name;
  Pose origin;
  Vector3 axis = Vector3::UnitZ();
  double min_rad = 0.0, max_rad = 0.0, max_speed_rad_s = 0.0;  ///< 0, 0: the description has none
};

struct DescribedChain {
  std::vector<DescribedJoint> joints;
  Pose tip;  ///< last link to the frame asked for
};

/// 1 to kMaxJoints joints; the axes need not be unit vectors but must not vanish.
SerialChain to_serial_chain(const DescribedChain& described);

/// Fixed-axis roll, pitch, yaw of R = Rz(y) Ry(p) Rx(r), exact also at p = ±π/2.
Vector3 to_rpy(const Matrix3& R);
Matrix3 from_rpy(const Vector3& rpy_rad);

/// The joints between two links of a URDF file, fixed ones folded in. Throws ConfigError
/// naming what, where, which rule.
DescribedChain read_urdf_chain(const std::filesystem::path& file, const std::string& base, const std::string& tip);

}  // namespace armsight::host
