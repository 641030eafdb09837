#include "tools/convert/convert.hpp"

#include "protocol/config_error.hpp"

namespace armsight::tools {

int convert(const std::string& kind, const Path& source, const Path& target) {
  if (kind == "talos") return convert_talos(source, "measurements-pyrene-20200819-1.csv", target);
  if (kind == "rct") return convert_rct(source, target);
  if (kind == "ur10e") return convert_ur10e(source, target);
  if (kind == "camodocal") return convert_camodocal(source, target);
  if (kind == "ethz") return convert_ethz(source, target);
  throw ConfigError("KIND = " + kind + ": must be talos, rct, ur10e, camodocal or ethz");
}

}  // namespace armsight::tools
