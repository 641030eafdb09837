// Small figures for paper and screen: axes with units, legend, colours that colour-blind readers can tell apart
// (Okabe and Ito) and a different mark for each series, so that they survive grey printing too. No dependency.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace armsight::demo {

/// Okabe–Ito, in the order of use.
inline constexpr const char* kBlue = "#0072B2";
inline constexpr const char* kVermillion = "#D55E00";
inline constexpr const char* kGreen = "#009E73";
inline constexpr const char* kPurple = "#CC79A7";
inline constexpr const char* kSky = "#56B4E9";
inline constexpr const char* kOrange = "#E69F00";
inline constexpr const char* kBlack = "#333333";
inline constexpr const char* kGrey = "#9aa3ab";
const char* series_color(std::size_t index);

enum class Mark { kNone, kCircle, kSquare, kTriangle, kDiamond, kCross, kRing };
Mark series_mark(std::size_t index);

struct Series {
  std::string label = {};  ///< empty: not in the legend
  std::vector<double> x = {}, y = {};
  std::string color = kBlue;
  Mark mark = Mark::kCircle;
  bool has_line = true;
  bool is_dashed = false;
  double width_px = 2.0;
};

struct Bar {
  std::string label = {};       ///< in the legend
  std::vector<double> heights = {};  ///< one a group
  std::string color = kBlue;
};

struct Circle {
  double x = 0, y = 0, radius = 0;
  std::string label = {};
};

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  int width_px = 520, height_px = 340;
  std::vector<Series> series = {};
  std::vector<Bar> bars = {};         ///< grouped by `groups`
  std::vector<std::string> groups = {};    ///< texts on the x axis, at 0, 1, 2 …
  std::vector<Circle> circles = {};
  bool has_equal_axes = false;           ///< one unit is as long in x as in y
  bool is_y_down = false;                ///< image coordinates
  bool starts_at_zero = false;           ///< y
  std::optional<double> reference_y = {};    ///< a dashed line, e.g. a tolerance
  std::string reference_label = {};
};

/// An <svg> element that needs nothing around it. Values that are not finite are left out.
std::string to_svg(const Plot& plot);
/// Ticks at 1, 2 or 5 times a power of ten, about `wanted` of them, covering [min, max].
std::vector<double> nice_ticks(double min, double max, int wanted);
/// "0.25", "-3", "1.2e-05": short, the same everywhere.
std::string short_number(double value, int digits = 3);
std::string escape_html(const std::string& text);

}  // namespace armsight::demo
