// A marker to print: true scale on A4, with white margin, its name, and a ruler of 100 mm to check the printer by.
// Millimetres; in the layout y runs down from the page's upper edge.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/config.hpp"

namespace armsight::host {

struct PrintRectangle {
  double x_mm, y_mm, width_mm, height_mm;
};
struct PrintText {
  double x_mm, y_mm, size_mm;  ///< baseline's left end
  std::string text;
};
struct PrintLayout {
  double page_width_mm = 210.0, page_height_mm = 297.0;
  std::vector<PrintRectangle> black;  ///< marker first, then cut marks and ruler
  std::vector<PrintText> texts;
};

/// Throws ConfigError: unknown dictionary or id; a side below 5 mm or beyond what A4 carries with its margin.
PrintLayout marker_layout(const MarkerConfig& marker);
std::string to_svg(const PrintLayout& layout);
std::string to_pdf(const PrintLayout& layout);
/// By the ending, .svg or .pdf; ConfigError for others or where the file cannot be written.
void save_marker_print(const MarkerConfig& marker, const std::filesystem::path& file);

}  // namespace armsight::host
