// Ticks, numbers, colours and escaping of the figures.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tools/report/svg_plot.hpp"

namespace armsight::demo {

const char* series_color(std::size_t index) {
  constexpr std::array kColors{kBlue, kVermillion, kGreen, kPurple, kOrange, kSky, kBlack, kGrey};
  return kColors[index % kColors.size()];
}

Mark series_mark(std::size_t index) {
  constexpr std::array kMarks{Mark::kCircle, Mark::kSquare, Mark::kTriangle, Mark::kDiamond, Mark::kCross, Mark::kRing};
  return kMarks[index % kMarks.size()];
}

std::vector<double> nice_ticks(double min, double max, int wanted) {
  if (!(max > min) || wanted < 1) return {};
  const double rough = (max - min) / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= 0.75 * rough) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> ticks;
  for (double i = std::ceil(min / step - 1e-9); i * step <= max + 1e-9 * step; i += 1.0)
    ticks.push_back(i * step + 0.0);
  return ticks;
}

std::string short_number(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (std::abs(value) < 1e-12) return "0";
  // Fixed digits below 1000, so that 12.3 does not become 1.2e+01 when two digits are asked for.
  const double magnitude = std::floor(std::log10(std::abs(value)));
  std::array<char, 40> text{};
  if (magnitude < -4 || magnitude > 6) {
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
  }
  const int decimals = std::max(0, digits - 1 - static_cast<int>(magnitude));
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  std::string out = text.data();
  if (out.find('.') != std::string::npos) {
    out.erase(out.find_last_not_of('0') + 1);
    if (out.back() == '.') out.pop_back();
  }
  return out;
}

std::string escape_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace armsight::demo
