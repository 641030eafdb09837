#include "shared/arm_model.hpp"

#include <cmath>

namespace armsight {

Pose dh_transform(const DhRow& row) {
  const double ct = std::cos(row.theta_rad), st = std::sin(row.theta_rad);
  const double ca = std::cos(row.alpha_rad), sa = std::sin(row.alpha_rad);
  Pose T;
  T.R << ct, -st * ca, st * sa,  //
      st, ct * ca, -ct * sa,     //
      0, sa, ca;
  T.p << row.a_m * ct, row.a_m * st, row.d_m;
  return T;
}

}  // namespace armsight
