// Printed markers: true to scale in SVG and PDF, and our own detector reads what was printed.
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <regex>
#include <sstream>

#include "host/marker.hpp"
#include "host/marker_print.hpp"
#include "host/overlay.hpp"
#include "protocol/config_error.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::host {
namespace {

struct Rectangle { double x, y, width, height; };

std::vector<Rectangle> match_all(const std::string& text, const std::regex& pattern) {
  std::vector<Rectangle> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    found.push_back({std::stod((*at)[1]), std::stod((*at)[2]), std::stod((*at)[3]), std::stod((*at)[4])});
  }
  return found;
}

const std::regex kSvgRectangle("<rect x=\"([-\\d.]+)\" y=\"([-\\d.]+)\" width=\"([\\d.]+)\" height=\"([\\d.]+)\"");
const std::regex kPdfRectangle("([-\\d.]+) ([-\\d.]+) ([\\d.]+) ([\\d.]+) re");

/// Area coverage at `scale` px/mm of an A4 page.
cv::Mat rasterised(const std::vector<Rectangle>& rectangles_mm, int scale) {
  cv::Mat page(297 * scale, 210 * scale, CV_8UC1, cv::Scalar(255));
  for (const Rectangle& r : rectangles_mm) {
    const cv::Point from(cvRound(r.x * scale), cvRound(r.y * scale));
    const cv::Point to(cvRound((r.x + r.width) * scale), cvRound((r.y + r.height) * scale));
    page(cv::Rect(from, to) & cv::Rect(0, 0, page.cols, page.rows)).setTo(0);
  }
  return page;
}

/// Side of the marker as our detector measures it on the page, mm.
double measured_side_mm(const std::vector<Rectangle>& rectangles_mm, int id) {
  constexpr int kScale = 6;
  const cv::Mat page = rasterised(rectangles_mm, kScale);
  const Intrinsics flat{page.cols, page.rows, 1000, 1000, page.cols / 2.0, page.rows / 2.0, {}};
  for (const MarkerDetection& marker : MarkerDetector("DICT_4X4_50").detect(page, flat)) {
    if (marker.id != id) continue;
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) sum += cv::norm(marker.corners_px[(i + 1) % 4] - marker.corners_px[i]) / 4.0;
    return sum / kScale;
  }
  return 0.0;
}

TEST(MarkerPrint, SvgIsTrueToScale) {
  const std::string svg = to_svg(marker_layout({"DICT_4X4_50", 7, 0.050}));
  EXPECT_NE(svg.find("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""), std::string::npos);
  const auto rectangles = match_all(svg, kSvgRectangle);
  EXPECT_NEAR(measured_side_mm(rectangles, 7), 50.0, 0.1);
  const auto ruler =
      std::find_if(rectangles.begin(), rectangles.end(), [](const Rectangle& r) { return r.width == 100.0; });
  EXPECT_NE(ruler, rectangles.end());
}

TEST(MarkerPrint, PdfIsTrueToScaleAndAsksForNoScaling) {
  const std::string pdf = to_pdf(marker_layout({"DICT_4X4_50", 12, 0.040}));
  EXPECT_EQ(pdf.substr(0, 8), "%PDF-1.4");
  EXPECT_NE(pdf.find("/MediaBox [0 0 595.2756 841.8898]"), std::string::npos);
  EXPECT_NE(pdf.find("/PrintScaling /None"), std::string::npos);
  std::vector<Rectangle> rectangles = match_all(pdf, kPdfRectangle);
  for (Rectangle& r : rectangles) {  // points from the lower edge → mm from the upper
    const double mm = 25.4 / 72.0;
    r = {r.x * mm, 297.0 - (r.y + r.height) * mm, r.width * mm, r.height * mm};
  }
  EXPECT_NEAR(measured_side_mm(rectangles, 12), 40.0, 0.1);
}

TEST(MarkerPrint, PdfIndexPointsAtItsObjects) {
  const std::string pdf = to_pdf(marker_layout({"DICT_4X4_50", 0, 0.1}));
  const std::size_t index = std::stoul(pdf.substr(pdf.find("startxref\n") + 10));
  ASSERT_EQ(pdf.substr(index, 5), "xref\n");
  for (std::size_t object = 1; object <= 5; ++object) {
    const std::size_t entry = pdf.find("\n", index + 5) + 1 + 20 * object;
    const std::size_t at = std::stoul(pdf.substr(entry, 10));
    EXPECT_EQ(pdf.substr(at, 7), std::to_string(object) + " 0 obj");
  }
  const std::size_t stream = pdf.find("stream\n") + 7, end = pdf.find("endstream");
  EXPECT_NE(pdf.find("/Length " + std::to_string(end - stream) + " "), std::string::npos);
}

TEST(MarkerPrint, ImpossibleMarkersAreRefused) {
  EXPECT_THROW(marker_layout({"DICT_4X4_50", 50, 0.05}), ConfigError);
  EXPECT_THROW(marker_layout({"DICT_9X9", 1, 0.05}), ConfigError);
  EXPECT_THROW(marker_layout({"DICT_4X4_50", 1, 0.30}), ConfigError);
  EXPECT_THROW(marker_layout({"DICT_4X4_50", 1, 0.0}), ConfigError);
  EXPECT_THROW(save_marker_print({"DICT_4X4_50", 1, 0.05}, "marker.docx"), ConfigError);
}

TEST(MarkerPrint, FilesHoldWhatWasLaidOut) {
  const TemporaryFolder folder;
  for (const char* name : {"m.svg", "m.pdf"}) {
    save_marker_print({"DICT_4X4_50", 7, 0.05}, folder.file(name));
    std::stringstream text;
    text << std::ifstream(folder.file(name)).rdbuf();
    const PrintLayout layout = marker_layout({"DICT_4X4_50", 7, 0.05});
    EXPECT_EQ(text.str(), std::string(name) == "m.svg" ? to_svg(layout) : to_pdf(layout));
  }
}

TEST(OverlayPicture, DrawsOnACopyAndIsSaved) {
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(90));
  Overlay overlay;
  overlay.markers.push_back({7, {cv::Point2d(100, 100), {140, 100}, {140, 140}, {100, 140}}, 0.02});
  overlay.measured_T_C_H = Pose{Matrix3::Identity(), Vector3(0, 0, 0.4)};
  overlay.lines = {"look 1 of 5"};
  const cv::Mat drawn = draw_overlay(grey, {320, 240, 300, 300, 160, 120, {}}, overlay);
  EXPECT_EQ(drawn.type(), CV_8UC3);
  EXPECT_NE(drawn.at<cv::Vec3b>(100, 120), cv::Vec3b(90, 90, 90));
  EXPECT_EQ(drawn.at<cv::Vec3b>(220, 300), cv::Vec3b(90, 90, 90));
  const TemporaryFolder folder;
  save_image(folder.file("deep/er/look.jpg"), drawn);
  EXPECT_GT(std::filesystem::file_size(folder.file("deep/er/look.jpg")), 1000U);
  EXPECT_THROW(save_image(folder.file("look.unknown"), drawn), std::runtime_error);
}

}  // namespace
}  // namespace armsight::host
