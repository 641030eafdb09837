#include "host/marker_print.hpp"

#include <cstdio>
#include <fstream>

#include "host/marker.hpp"
#include "protocol/config_error.hpp"

namespace armsight::host {
namespace {

constexpr double kTop_mm = 30.0;             // margin's upper edge
constexpr double kMarginModules = 2.0;       // white around the marker (detectors need one, prefer two)
constexpr double kLine_mm = 0.2;
constexpr double kRuler_mm = 100.0;
constexpr double kPoints = 72.0 / 25.4;      // PDF points a mm

template <typename... Numbers>
std::string format(const char* pattern, Numbers... numbers) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, numbers...);
  return text;
}

/// Modules of a row that touch are one rectangle: no hairline between them on any printer.
void add_marker(const MarkerPattern& pattern, double x_mm, double y_mm, double side_mm, PrintLayout& layout) {
  const double module = side_mm / pattern.modules;
  for (int row = 0; row < pattern.modules; ++row) {
    for (int column = 0; column < pattern.modules;) {
      int end = column;
      while (end < pattern.modules && !pattern.at(row, end)) ++end;
      if (end > column)
        layout.black.push_back({x_mm + column * module, y_mm + row * module, (end - column) * module, module});
      column = end + 1;
    }
  }
}

void add_cut_marks(double x_mm, double y_mm, double side_mm, PrintLayout& layout) {
  constexpr double kLength_mm = 4.0;
  for (const double x : {x_mm, x_mm + side_mm}) {
    for (const double y : {y_mm, y_mm + side_mm}) {
      const bool is_left = x == x_mm, is_upper = y == y_mm;
      layout.black.push_back({is_left ? x - kLength_mm : x, y - kLine_mm / 2, kLength_mm, kLine_mm});
      layout.black.push_back({x - kLine_mm / 2, is_upper ? y - kLength_mm : y, kLine_mm, kLength_mm});
    }
  }
}

void add_ruler(double x_mm, double y_mm, PrintLayout& layout) {
  layout.black.push_back({x_mm, y_mm - kLine_mm / 2, kRuler_mm, kLine_mm});
  for (int mm = 0; mm <= static_cast<int>(kRuler_mm); ++mm) {
    const double height = mm % 10 == 0 ? 5.0 : mm % 5 == 0 ? 3.5 : 2.0;
    layout.black.push_back({x_mm + mm - kLine_mm / 2, y_mm - height, kLine_mm, height});
    if (mm % 50 == 0) layout.texts.push_back({x_mm + mm + 0.8, y_mm - 5.6, 3.0, std::to_string(mm)});
  }
  const PrintText advice{x_mm, y_mm + 5.0, 3.2,
                         "100 mm between the outer ticks, else print again without scaling (100 %)"};
  layout.texts.push_back(advice);
}

}  // namespace

PrintLayout marker_layout(const MarkerConfig& marker) {
  const MarkerPattern pattern = marker_pattern(marker.dictionary, marker.id);
  const double side_mm = marker.side_m * 1000.0;
  const double margin_mm = kMarginModules * side_mm / pattern.modules;
  PrintLayout layout;
  const double plate_mm = side_mm + 2.0 * margin_mm;
  if (!(side_mm >= 5.0) || plate_mm > layout.page_width_mm - 20.0) {
    throw ConfigError(format("marker side = %g mm: must be 5 mm or more, and with its margin fit on A4 (up to %g mm)",
                             side_mm, 190.0 * pattern.modules / (pattern.modules + 2.0 * kMarginModules)));
  }
  const double plate_x = 0.5 * (layout.page_width_mm - plate_mm);
  add_marker(pattern, plate_x + margin_mm, kTop_mm + margin_mm, side_mm, layout);
  add_cut_marks(plate_x, kTop_mm, plate_mm, layout);
  layout.texts.push_back({plate_x, kTop_mm - 6.0, 4.0,
                          marker.dictionary + "  id " + std::to_string(marker.id) + format("  side %g mm", side_mm)});
  add_ruler(0.5 * (layout.page_width_mm - kRuler_mm), kTop_mm + plate_mm + 25.0, layout);
  const PrintText instruction{0.5 * (layout.page_width_mm - kRuler_mm), kTop_mm + plate_mm + 36.0, 3.2,
                              "side = black border, outer edge to outer edge. Cut at the corners; "
                              "glue flat, matt side up."};
  layout.texts.push_back(instruction);
  return layout;
}

std::string to_svg(const PrintLayout& layout) {
  std::string out =
      format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%gmm\" height=\"%gmm\" viewBox=\"0 0 %g %g\">\n",
             layout.page_width_mm, layout.page_height_mm, layout.page_width_mm, layout.page_height_mm);
  out +=
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<g fill=\"black\" "
      "shape-rendering=\"geometricPrecision\">\n";
  for (const PrintRectangle& r : layout.black) {
    out += format("<rect x=\"%.5f\" y=\"%.5f\" width=\"%.5f\" height=\"%.5f\"/>\n", r.x_mm, r.y_mm, r.width_mm,
                  r.height_mm);
  }
  for (const PrintText& t : layout.texts) {
    out += format("<text x=\"%.3f\" y=\"%.3f\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"%.2f\">",
                  t.x_mm, t.y_mm, t.size_mm) +
           t.text + "</text>\n";
  }
  return out + "</g>\n</svg>\n";
}

std::string to_pdf(const PrintLayout& layout) {
  std::string page = "0 g\n";
  for (const PrintRectangle& r : layout.black) {
    page +=
        format("%.5f %.5f %.5f %.5f re\n", r.x_mm * kPoints, (layout.page_height_mm - r.y_mm - r.height_mm) * kPoints,
               r.width_mm * kPoints, r.height_mm * kPoints);
  }
  page += "f\n";
  for (const PrintText& t : layout.texts) {
    page += format("BT /F1 %.3f Tf %.4f %.4f Td (", t.size_mm * kPoints, t.x_mm * kPoints,
                   (layout.page_height_mm - t.y_mm) * kPoints);
    for (const char c : t.text) {
      if (c == '(' || c == ')' || c == '\\') page += '\\';
      page += c;
    }
    page += ") Tj ET\n";
  }
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R " +
          format("/MediaBox [0 0 %.4f %.4f] ", layout.page_width_mm * kPoints, layout.page_height_mm * kPoints) +
          "/Resources << /Font << /F1 5 0 R >> >> /Contents 4 0 R >>",
      "<< /Length " + std::to_string(page.size()) + " >>\nstream\n" + page + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string out = "%PDF-1.4\n";
  std::string index = "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    index += format("%010zu 00000 n \n", out.size());
    out += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::size_t index_at = out.size();
  return out + "xref\n0 " + std::to_string(objects.size() + 1) + "\n" + index + "trailer\n<< /Size " +
         std::to_string(objects.size() + 1) + " /Root 1 0 R >>\nstartxref\n" + std::to_string(index_at) + "\n%%EOF\n";
}

void save_marker_print(const MarkerConfig& marker, const std::filesystem::path& file) {
  const bool is_svg = file.extension() == ".svg", is_pdf = file.extension() == ".pdf";
  if (!is_svg && !is_pdf) throw ConfigError(file.string() + ": must end in .svg or .pdf");
  const PrintLayout layout = marker_layout(marker);
  std::ofstream out(file, std::ios::binary);
  out << (is_svg ? to_svg(layout) : to_pdf(layout));
  if (!out.flush()) throw ConfigError(file.string() + ": cannot be written");
}

}  // namespace armsight::host
