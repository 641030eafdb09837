// The elastic transmission of a soft actuator: two antagonistic springs between motors and link, whose preset sets the
// stiffness (specification §4.4). δ = q − equilibrium, positive torque turns the link towards +q and is what the spring
// gives it, so τ(δ) falls with δ. rad, N·m. Pure, no heap.
#pragma once

#include <cstdint>

namespace armsight {

enum class SpringLaw : std::uint8_t {
  kTan,  ///< τ = −k [tan(a(δ + p)) + tan(a(δ − p))], the 2018–19 law
  kSinh  ///< τ = −2 k cosh(a p) sinh(a δ), the 2021 law with equal springs
};

struct Spring {
  SpringLaw law = SpringLaw::kSinh;
  double k_Nm = 0.0;
  double a_per_rad = 1.0;
  double preset_rad = 0.0;          ///< p; kTan needs a(p + |δ|) < π/2
  double max_deflection_rad = 0.8;  ///< where it meets its stop
};

/// Torque on the link at deflection δ.
double spring_torque(const Spring& spring, double deflection_rad);
/// −dτ/dδ > 0.
double spring_stiffness(const Spring& spring, double deflection_rad);
/// The deflection at which the spring gives `torque_Nm`: the closed inverse of the law, cut to ± max_deflection_rad.
double spring_deflection(const Spring& spring, double torque_Nm);

}  // namespace armsight
