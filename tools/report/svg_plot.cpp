#include "tools/report/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace armsight::demo {

namespace {

constexpr double kLeft = 62, kRight = 16, kTop = 38, kBottom = 50, kLegendRow = 19;

struct Range {
  double min = std::numeric_limits<double>::infinity(), max = -std::numeric_limits<double>::infinity();
  void include(double v) {
    if (!std::isfinite(v)) return;
    min = std::min(min, v);
    max = std::max(max, v);
  }
  void widen(double share) {
    if (min > max) min = 0, max = 1;
    const double margin = std::max(share * (max - min), 1e-9 + 1e-3 * std::max(std::abs(min), std::abs(max)));
    min -= margin;
    max += margin;
  }
};

/// Data coordinates → pixels of the drawing.
struct Frame {
  Range x, y;
  double left = 0, top = 0, width = 0, height = 0;
  bool is_y_down = false;
  double px(double v) const { return left + (v - x.min) / (x.max - x.min) * width; }
  double py(double v) const {
    const double share = (v - y.min) / (y.max - y.min);
    return top + (is_y_down ? share : 1.0 - share) * height;
  }
};

std::string f1(double v) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.1f", v);
  return text.data();
}

std::string text_at(double x, double y, const std::string& text, const std::string& style,
                    const char* anchor = "middle") {
  return "<text x=\"" + f1(x) + "\" y=\"" + f1(y) + "\" text-anchor=\"" + anchor + "\" " + style + ">" +
         escape_html(text) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + f1(x1) + "\" y1=\"" + f1(y1) + "\" x2=\"" + f1(x2) + "\" y2=\"" + f1(y2) + "\" " + style +
         "/>";
}

std::string polygon(const std::vector<std::array<double, 2>>& points, const std::string& style) {
  std::string out = "<polygon points=\"";
  for (const auto& p : points) out += f1(p[0]) + "," + f1(p[1]) + " ";
  return out + "\" " + style + "/>";
}

std::string mark_at(Mark mark, double x, double y, const std::string& color) {
  const std::string fill = "fill=\"" + color + "\" stroke=\"#fff\" stroke-width=\"1\"";
  const std::string open = "fill=\"none\" stroke=\"" + color + "\" stroke-width=\"2\"";
  switch (mark) {
    case Mark::kNone: return "";
    case Mark::kCircle: return "<circle cx=\"" + f1(x) + "\" cy=\"" + f1(y) + "\" r=\"4.5\" " + fill + "/>";
    case Mark::kRing: return "<circle cx=\"" + f1(x) + "\" cy=\"" + f1(y) + "\" r=\"6\" " + open + "/>";
    case Mark::kSquare: return polygon({{x - 4, y - 4}, {x + 4, y - 4}, {x + 4, y + 4}, {x - 4, y + 4}}, fill);
    case Mark::kTriangle: return polygon({{x, y - 5}, {x + 5, y + 4}, {x - 5, y + 4}}, fill);
    case Mark::kDiamond: return polygon({{x, y - 5.5}, {x + 5.5, y}, {x, y + 5.5}, {x - 5.5, y}}, fill);
    case Mark::kCross: return line(x - 5, y - 5, x + 5, y + 5, open) + line(x - 5, y + 5, x + 5, y - 5, open);
  }
  return "";
}

struct LegendEntry {
  std::string label, color;
  Mark mark;
  bool has_line, is_bar, is_dashed;
};

std::vector<LegendEntry> legend_of(const Plot& plot) {
  std::vector<LegendEntry> entries;
  for (const Bar& b : plot.bars) entries.push_back({b.label, b.color, Mark::kNone, false, true, false});
  for (const Series& s : plot.series) {
    if (!s.label.empty()) entries.push_back({s.label, s.color, s.mark, s.has_line, false, s.is_dashed});
  }
  if (plot.reference_y) entries.push_back({plot.reference_label, "#4a5560", Mark::kNone, true, false, true});
  return entries;
}

/// A guess that is wide enough: letters of 12 px; bytes that continue a UTF-8 letter take no room.
double entry_width(const LegendEntry& entry) {
  const auto letters = std::ranges::count_if(entry.label, [](char c) { return (c & 0xC0) != 0x80; });
  return 44 + 7.0 * static_cast<double>(letters);
}

/// Rows of entries that fit the width; returns the SVG and the number of rows.
std::pair<std::string, int> draw_legend(const std::vector<LegendEntry>& entries, double width, double first_y) {
  std::string out;
  double x = kLeft;
  int row = 0;
  for (const LegendEntry& e : entries) {
    if (x > kLeft && x + entry_width(e) > width) {
      x = kLeft;
      ++row;
    }
    const double y = first_y + kLegendRow * row;
    if (e.is_bar)
      out += "<rect x=\"" + f1(x + 5) + "\" y=\"" + f1(y - 6) + "\" width=\"12\" height=\"12\" rx=\"2\" fill=\"" +
             e.color + "\"/>";
    if (e.has_line) {
      out += line(x, y, x + 22, y,
                  "stroke=\"" + e.color + "\" stroke-width=\"2\"" + (e.is_dashed ? " stroke-dasharray=\"5 4\"" : ""));
    }
    out += mark_at(e.mark, x + 11, y, e.color);
    out += text_at(x + 28, y + 4, e.label, "class=\"k\"", "start");
    x += entry_width(e);
  }
  return {out, entries.empty() ? 0 : row + 1};
}

void fit(Frame& frame, const Plot& plot) {
  for (const Series& s : plot.series) {
    for (double v : s.x) frame.x.include(v);
    for (double v : s.y) frame.y.include(v);
  }
  for (const Circle& c : plot.circles) {
    frame.x.include(c.x - c.radius), frame.x.include(c.x + c.radius);
    frame.y.include(c.y - c.radius), frame.y.include(c.y + c.radius);
  }
  for (const Bar& b : plot.bars) {
    for (double v : b.heights) frame.y.include(v);
  }
  if (plot.reference_y) frame.y.include(*plot.reference_y);
  const bool has_zero = plot.starts_at_zero || !plot.bars.empty();
  if (has_zero) frame.y.include(0.0);
  frame.x.widen(0.05);
  frame.y.widen(plot.bars.empty() ? 0.08 : 0.12);
  if (has_zero && frame.y.min > -0.2 * frame.y.max) frame.y.min = 0.0;
  if (!plot.groups.empty()) {
    frame.x.min = -0.5;
    frame.x.max = static_cast<double>(plot.groups.size()) - 0.5;
  }
  if (!plot.has_equal_axes) return;
  const double per_px = std::max((frame.x.max - frame.x.min) / frame.width, (frame.y.max - frame.y.min) / frame.height);
  const double more_x = 0.5 * (per_px * frame.width - (frame.x.max - frame.x.min));
  const double more_y = 0.5 * (per_px * frame.height - (frame.y.max - frame.y.min));
  frame.x = {frame.x.min - more_x, frame.x.max + more_x};
  frame.y = {frame.y.min - more_y, frame.y.max + more_y};
}

std::string draw_axes(const Frame& f, const Plot& plot) {
  std::string out;
  const double bottom = f.top + f.height, right = f.left + f.width;
  for (double v : nice_ticks(f.y.min, f.y.max, 5)) {
    out += line(f.left, f.py(v), right, f.py(v), "class=\"g\"");
    out += text_at(f.left - 7, f.py(v) + 4, short_number(v), "class=\"t\"", "end");
  }
  for (std::size_t i = 0; i < plot.groups.size(); ++i) {
    out += text_at(f.px(static_cast<double>(i)), bottom + 18, plot.groups[i], "class=\"t\"");
  }
  if (plot.groups.empty()) {
    for (double v : nice_ticks(f.x.min, f.x.max, 6)) {
      out += line(f.px(v), f.top, f.px(v), bottom, "class=\"g\"");
      out += text_at(f.px(v), bottom + 18, short_number(v), "class=\"t\"");
    }
  }
  out += line(f.left, bottom, right, bottom, "class=\"a\"") + line(f.left, f.top, f.left, bottom, "class=\"a\"");
  out += text_at(f.left + 0.5 * f.width, bottom + 40, plot.x_label, "class=\"l\"");
  const double middle = f.top + 0.5 * f.height;
  out += text_at(16, middle, plot.y_label, "class=\"l\" transform=\"rotate(-90 16 " + f1(middle) + ")\"");
  return out;
}

std::string draw_bars(const Frame& f, const Plot& plot) {
  std::string out;
  const double slot = 0.74 / static_cast<double>(std::max<std::size_t>(1, plot.bars.size()));
  for (std::size_t b = 0; b < plot.bars.size(); ++b) {
    for (std::size_t i = 0; i < plot.bars[b].heights.size(); ++i) {
      const double value = plot.bars[b].heights[i];
      if (!std::isfinite(value)) continue;
      const double x = f.px(static_cast<double>(i) - 0.37 + slot * static_cast<double>(b));
      const double width = f.px(slot) - f.px(0) - 2;
      const double y = std::min(f.py(value), f.py(0)), height = std::abs(f.py(0) - f.py(value));
      out += "<rect x=\"" + f1(x) + "\" y=\"" + f1(y) + "\" width=\"" + f1(width) + "\" height=\"" +
             f1(std::max(height, 0.5)) + "\" rx=\"2\" fill=\"" + plot.bars[b].color + "\"/>";
      const double label_y = value >= 0 ? y - 5 : y + height + 12;
      if (width > 12) out += text_at(x + 0.5 * width, label_y, short_number(value, 2), "class=\"v\"");
    }
  }
  return out;
}

std::string draw_series(const Frame& f, const Series& s) {
  std::string path, marks;
  bool is_down = false;
  for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
    if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) {
      is_down = false;
      continue;
    }
    path += (is_down ? "L" : "M") + f1(f.px(s.x[i])) + " " + f1(f.py(s.y[i])) + " ";
    marks += mark_at(s.mark, f.px(s.x[i]), f.py(s.y[i]), s.color);
    is_down = true;
  }
  if (!s.has_line) return marks;
  return "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + s.color + "\" stroke-width=\"" + f1(s.width_px) +
         "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"" + (s.is_dashed ? " stroke-dasharray=\"5 4\"" : "") +
         "/>" + marks;
}

std::string draw_circle(const Frame& f, const Circle& c) {
  const double radius = f.px(c.radius) - f.px(0);
  return "<circle cx=\"" + f1(f.px(c.x)) + "\" cy=\"" + f1(f.py(c.y)) + "\" r=\"" + f1(radius) +
         "\" fill=\"#009E73\" fill-opacity=\"0.08\" stroke=\"#009E73\" stroke-dasharray=\"4 3\"/>" +
         text_at(f.px(c.x), f.py(c.y) - radius - 6, c.label, "class=\"v\"");
}

}  // namespace

std::string to_svg(const Plot& plot) {
  const auto [legend, rows] = draw_legend(legend_of(plot), plot.width_px, kTop);
  Frame f;
  f.left = kLeft;
  f.top = kTop + (rows > 0 ? kLegendRow * rows - 4 : -8);
  f.width = plot.width_px - kLeft - kRight;
  f.height = plot.height_px - f.top - kBottom;
  f.is_y_down = plot.is_y_down;
  fit(f, plot);

  const std::string size = std::to_string(plot.width_px) + " " + std::to_string(plot.height_px);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + size +
                    "\" role=\"img\" aria-label=\"" + escape_html(plot.title) +
                    "\" font-family=\"system-ui,'Segoe UI','DejaVu Sans',Helvetica,Arial,sans-serif\">";
  out += "<style>.g{stroke:#e6e9ec;stroke-width:1}.a{stroke:#4a5560;stroke-width:1.2}.t{font-size:11.5px;fill:#4a5560}"
         ".l{font-size:12.5px;fill:#1d252c}.k{font-size:12px;fill:#1d252c}.v{font-size:10.5px;fill:#1d252c}"
         ".h{font-size:14px;font-weight:600;fill:#1d252c}</style>";
  out += text_at(kLeft, 18, plot.title, "class=\"h\"", "start") + draw_axes(f, plot) + legend;
  for (const Circle& c : plot.circles) out += draw_circle(f, c);
  out += draw_bars(f, plot);
  for (const Series& s : plot.series) out += draw_series(f, s);
  if (plot.reference_y) {
    out += line(f.left, f.py(*plot.reference_y), f.left + f.width, f.py(*plot.reference_y),
                "stroke=\"#4a5560\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\"");
  }
  return out + "</svg>";
}

}  // namespace armsight::demo
