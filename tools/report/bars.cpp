#include "tools/report/bars.hpp"

#include <cstdio>
#include <map>

namespace armsight::demo {
namespace {

const std::map<std::string, Bars> kBars = {{"clean", {{1.2, 0.55}, {1.7, 0.6}}},
                                           {"nominal", {{2.4, 1.1}, {3.4, 1.2}}},
                                           {"hard", {{4.8, 2.2}, {6.8, 2.4}}}};

// Written so that a figure that is none misses, too.
void judge(const std::string& what, const PoseError& error, const PoseError& bar, std::vector<std::string>& missed) {
  if (error.mm <= bar.mm && error.deg <= bar.deg) return;
  char text[120];
  std::snprintf(text, sizeof text, ": %.2f mm, %.2f deg: must be at most %.1f mm, %.2f deg", error.mm, error.deg,
                bar.mm, bar.deg);
  missed.push_back(what + text);
}

void judge_verdict(const std::string& filter, const GraspEvaluation& grasp, const GraspResult& result,
                   std::vector<std::string>& missed) {
  if (grasp.does_verdict_agree) return;
  missed.push_back("grasp " + filter + " filter: the host's verdict \"" + result.verdict +
                   "\" is not what the simulator saw");
}

}  // namespace

const Bars& bars_of(const std::string& noise) { return kBars.at(noise); }

std::vector<std::string> missed_figures(const Report& report) {
  std::vector<std::string> missed;
  const Bars& bars = bars_of(report.noise);
  judge("Learn: held-out error", {report.heldout.rms_mm, report.heldout.rms_deg}, bars.heldout, missed);
  judge("Adapt: commanded poses with filter", median_model_error(report.with_filter), bars.commanded, missed);
  if (!report.with_grasp.is_success) missed.emplace_back("Act: the grasp with filter did not succeed");
  judge_verdict("with", report.with_grasp, report.grasp_with, missed);
  judge_verdict("without", report.without_grasp, report.grasp_without, missed);
  for (const std::string& name : report.controller.black_boxes) missed.push_back("a watchdog fired: " + name);
  return missed;
}

}  // namespace armsight::demo
