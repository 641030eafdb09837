// How the durations of the controller's cycle are spread: what share of them is not longer than so much.
#include <cmath>

#include "tools/report/report.hpp"

namespace armsight::demo {

namespace {

constexpr double kShortest_us = 0.1;  ///< what is shorter stands there: a logarithm has no zero

Series spread(const DurationRow& row, std::size_t index) {
  Series series{.label = row.name, .color = series_color(index), .mark = Mark::kNone, .has_line = true};
  double seen = 0.0;
  for (std::size_t i = 0; i < row.counts.size() && i < row.upper_ns.size(); ++i) {
    seen += static_cast<double>(row.counts[i]);
    series.x.push_back(std::log10(std::max(kShortest_us, 1e-3 * static_cast<double>(row.upper_ns[i]))));
    series.y.push_back(100.0 * seen / static_cast<double>(row.count));
  }
  series.x.insert(series.x.begin(), series.x.front());
  series.y.insert(series.y.begin(), 0.0);
  return series;
}

Plot spread_plot(const char* title) {
  return {.title = title,
          .x_label = "duration, 10^x µs (0: 1 µs, 3: 1 ms)",
          .y_label = "not longer [%]",
          .starts_at_zero = true};
}

}  // namespace

std::vector<Plot> controller_figures(const Report& r) {
  Plot cycle = spread_plot("The cycle"), answers = spread_plot("From SYNC to a node's answer");
  for (const DurationRow& row : r.controller.durations) {
    if (row.count == 0 || row.counts.empty() || row.upper_ns.empty()) continue;
    Plot& plot = row.name.starts_with("TPDO1") ? answers : cycle;
    plot.series.push_back(spread(row, plot.series.size()));
  }
  std::vector<Plot> plots;
  for (const Plot& plot : {cycle, answers})
    if (!plot.series.empty()) plots.push_back(plot);
  return plots;
}

}  // namespace armsight::demo
