#include "protocol/config_soft.hpp"

#include <numbers>

#include "protocol/config_values.hpp"

namespace armsight {

LinkMass read_link_mass(const YamlValue& joint) {
  const YamlValue link = joint.optional_key("link");
  if (!link.exists()) return {};
  return {link.key("mass_kg").number(0, 100), read_vector(link.key("com_m"), 2)};
}

Spring read_spring(const YamlValue& joint) {
  const YamlValue spring = joint.optional_key("spring");
  Spring out;
  if (!spring.exists()) return out;
  const YamlValue law = spring.key("law"), stop = spring.key("max_deflection_rad");
  const std::string name = law.text();
  if (name != "tan" && name != "sinh") law.refuse("must be tan or sinh");
  out.law = name == "tan" ? SpringLaw::kTan : SpringLaw::kSinh;
  out.k_Nm = spring.key("k_Nm").positive(1000);
  out.a_per_rad = spring.key("a_per_rad").positive(100);
  out.preset_rad = spring.key("preset_rad").number(0, 0.6);  // specification §4.4
  out.max_deflection_rad = stop.positive(1.5);
  const bool reaches_pole = out.a_per_rad * (out.preset_rad + out.max_deflection_rad) >= std::numbers::pi / 2;
  if (out.law == SpringLaw::kTan && reaches_pole) stop.refuse("a (preset + max_deflection) must be below π/2 for law tan");
  return out;
}

}  // namespace armsight
