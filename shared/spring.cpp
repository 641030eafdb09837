#include "shared/spring.hpp"

#include <algorithm>
#include <cmath>

namespace armsight {

double spring_torque(const Spring& s, double deflection_rad) {
  const double x = s.a_per_rad * deflection_rad, p = s.a_per_rad * s.preset_rad;
  if (s.law == SpringLaw::kTan) return -s.k_Nm * (std::tan(x + p) + std::tan(x - p));
  return -2.0 * s.k_Nm * std::cosh(p) * std::sinh(x);
}

double spring_stiffness(const Spring& s, double deflection_rad) {
  const double x = s.a_per_rad * deflection_rad, p = s.a_per_rad * s.preset_rad;
  if (s.law == SpringLaw::kSinh) return 2.0 * s.a_per_rad * s.k_Nm * std::cosh(p) * std::cosh(x);
  const double above = std::cos(x + p), below = std::cos(x - p);
  return s.a_per_rad * s.k_Nm * (1.0 / (above * above) + 1.0 / (below * below));
}

double spring_deflection(const Spring& s, double torque_Nm) {
  double x = 0.0;
  if (s.law == SpringLaw::kSinh) {
    x = std::asinh(-torque_Nm / (2.0 * s.k_Nm * std::cosh(s.a_per_rad * s.preset_rad)));
  } else {
    // tan(x + p) + tan(x − p) = G with t = tan p, u = tan x: G t² u² + 2(1 + t²) u − G = 0; the root that is 0 at G = 0,
    // written without the difference of near numbers.
    const double t = std::tan(s.a_per_rad * s.preset_rad), g = -torque_Nm / s.k_Nm, b = 1.0 + t * t;
    x = std::atan(g / (b + std::sqrt(b * b + g * g * t * t)));
  }
  return std::clamp(x / s.a_per_rad, -s.max_deflection_rad, s.max_deflection_rad);
}

}  // namespace armsight
