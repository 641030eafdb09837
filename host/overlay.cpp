#include "host/overlay.hpp"

#include <array>
#include <opencv2/imgproc.hpp>

namespace armsight::host {
namespace {

constexpr double kAxis_m = 0.04;
constexpr int kShift = 4;  // OpenCV draws in 1/16 px
const cv::Scalar kOutline(60, 220, 60), kFirstCorner(0, 200, 255), kText(255, 255, 255), kShade(20, 20, 20);
const std::array<cv::Scalar, 3> kAxes = {cv::Scalar(50, 50, 235), cv::Scalar(60, 200, 60), cv::Scalar(245, 130, 40)};
const std::array<cv::Scalar, 3> kPaleAxes = {cv::Scalar(170, 170, 250), cv::Scalar(180, 240, 180),
                                             cv::Scalar(250, 205, 170)};

cv::Point fine(const cv::Point2d& p) { return {cvRound(p.x * (1 << kShift)), cvRound(p.y * (1 << kShift))}; }

bool is_drawable(const cv::Mat& image, const cv::Point2d& p) {
  return p.x > -2.0 * image.cols && p.x < 3.0 * image.cols && p.y > -2.0 * image.rows && p.y < 3.0 * image.rows;
}

void draw_line(cv::Mat& image, const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& colour, int width) {
  if (is_drawable(image, a) && is_drawable(image, b))
    cv::line(image, fine(a), fine(b), colour, width, cv::LINE_AA, kShift);
}

void draw_axes(cv::Mat& image, const Intrinsics& k, const Pose& T, const std::array<cv::Scalar, 3>& colours,
               int width) {
  if (T.p.z() < 0.05) return;
  for (int i = 0; i < 3; ++i) {
    const Vector3 tip = T.p + kAxis_m * T.R.col(i);
    if (tip.z() > 0.02) draw_line(image, project(k, T.p), project(k, tip), colours[static_cast<std::size_t>(i)], width);
  }
}

void write(cv::Mat& image, const std::string& text, const cv::Point& at, double size) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kShade, 4, cv::LINE_AA);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kText, 1, cv::LINE_AA);
}

}  // namespace

cv::Mat draw_overlay(const cv::Mat& image, const Intrinsics& intrinsics, const Overlay& overlay) {
  cv::Mat picture;
  if (image.channels() == 1) cv::cvtColor(image, picture, cv::COLOR_GRAY2BGR);
  else picture = image.clone();
  for (const MarkerDetection& marker : overlay.markers) {
    for (std::size_t i = 0; i < 4; ++i) {
      draw_line(picture, marker.corners_px[i], marker.corners_px[(i + 1) % 4], kOutline, 2);
    }
    cv::circle(picture, fine(marker.corners_px[0]), 4 << kShift, kFirstCorner, cv::FILLED, cv::LINE_AA, kShift);
    write(picture, "id " + std::to_string(marker.id), cv::Point(marker.corners_px[1]) + cv::Point(8, -4), 0.5);
  }
  if (overlay.predicted_T_C_H) draw_axes(picture, intrinsics, *overlay.predicted_T_C_H, kPaleAxes, 4);
  if (overlay.measured_T_C_H) draw_axes(picture, intrinsics, *overlay.measured_T_C_H, kAxes, 2);
  if (overlay.object_T_C_O) draw_axes(picture, intrinsics, *overlay.object_T_C_O, kAxes, 2);
  int row = 28;
  for (const std::string& line : overlay.lines) {
    write(picture, line, {14, row}, 0.6);
    row += 24;
  }
  return picture;
}

}  // namespace armsight::host
