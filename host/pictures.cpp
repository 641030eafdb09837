#include "host/pictures.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace armsight::host {
namespace {

constexpr int kShift = 4;  // sub-pixel bits of OpenCV's drawing
constexpr double kAxis = 0.7;  // of the marker's side
const cv::Scalar kRed(60, 60, 235), kGreen(80, 200, 80), kBlue(235, 140, 60), kOutline(0, 215, 255), kInk(255, 255, 255), kShadow(0, 0, 0);

cv::Mat in_colour(const cv::Mat& picture) {
  cv::Mat out;
  if (picture.channels() == 1) cv::cvtColor(picture, out, cv::COLOR_GRAY2BGR);
  else out = picture.clone();
  return out;
}

cv::Point fixed_point(const cv::Point2d& p) {
  return {cvRound(p.x * (1 << kShift)), cvRound(p.y * (1 << kShift))};
}

void write_words(cv::Mat& picture, const std::string& words) {
  const cv::Point at(16, picture.rows - 18);
  cv::putText(picture, words, at, cv::FONT_HERSHEY_SIMPLEX, 0.7, kShadow, 4, cv::LINE_AA);
  cv::putText(picture, words, at, cv::FONT_HERSHEY_SIMPLEX, 0.7, kInk, 1, cv::LINE_AA);
}

void draw_axis(cv::Mat& picture, const Pose& T_C_M, const Vector3& tip_M, const Intrinsics& k, const cv::Scalar& colour) {
  const Vector3 tip_C = T_C_M * tip_M;
  if (tip_C.z() <= 0.01 || T_C_M.p.z() <= 0.01) return;
  cv::line(picture, fixed_point(project(k, T_C_M.p)), fixed_point(project(k, tip_C)), colour, 2, cv::LINE_AA, kShift);
}

}  // namespace

cv::Mat draw_words(const cv::Mat& picture, const std::string& words) {
  if (picture.empty()) return {};
  cv::Mat out = in_colour(picture);
  write_words(out, words);
  return out;
}

cv::Mat draw_look(const cv::Mat& picture, const LookMeasurement& look, const MarkerConfig& marker, const Pose& T_X_M,
                  const Intrinsics& intrinsics, const std::string& words) {
  if (picture.empty()) return {};
  cv::Mat out = in_colour(picture);
  for (std::size_t i = 0; i < 4; ++i) {
    cv::line(out, fixed_point(look.corners_px[i]), fixed_point(look.corners_px[(i + 1) % 4]), kOutline, 1, cv::LINE_AA, kShift);
  }
  const Pose T_C_M = look.T_C_H * T_X_M;
  const double length = kAxis * marker.side_m;
  draw_axis(out, T_C_M, Vector3(length, 0, 0), intrinsics, kRed);
  draw_axis(out, T_C_M, Vector3(0, length, 0), intrinsics, kGreen);
  draw_axis(out, T_C_M, Vector3(0, 0, length), intrinsics, kBlue);
  write_words(out, words);
  return out;
}

}  // namespace armsight::host
