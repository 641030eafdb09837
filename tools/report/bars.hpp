// What a single run must reach. The medians over ten seeds with nominal noise must be 1.2 mm and 0.55° held out, 1.7 mm
// and 0.6° with filter; one seed may be twice as far off. The hard set has about twice the nominal noise and gets twice
// that again, the clean one must keep to the medians.
#pragma once

#include <string>
#include <vector>

#include "tools/report/report.hpp"

namespace armsight::demo {

struct Bars {
  PoseError heldout;    ///< RMS over the held-out postures
  PoseError commanded;  ///< median over the commanded poses, with filter
};
/// Of "clean", "nominal" or "hard"; throws std::out_of_range for another name.
const Bars& bars_of(const std::string& noise);

/// What the run missed, a sentence each: bars, the grasp with filter, the host's verdicts, a watchdog that fired.
std::vector<std::string> missed_figures(const Report& report);

}  // namespace armsight::demo
