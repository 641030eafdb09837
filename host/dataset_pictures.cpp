// Corners of chessboards and markers in the pictures of a data set, and the start pose that corners give.
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "host/dataset_parts.hpp"
#include "host/marker.hpp"
#include "host/planar_pose.hpp"

namespace armsight::host {
namespace {

using Pixels = std::vector<Eigen::Vector2d>;

std::optional<Pixels> chessboard_corners(const cv::Mat& gray, const DatasetTarget& target) {
  std::vector<cv::Point2f> found;
  const cv::Size size(target.board_columns, target.board_rows);
  if (!cv::findChessboardCorners(gray, size, found, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return std::nullopt;
  }
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 60, 1e-4);
  cv::cornerSubPix(gray, found, cv::Size(5, 5), cv::Size(-1, -1), until);
  Pixels pixels;
  for (const auto& p : found) pixels.push_back(Eigen::Vector2d(static_cast<double>(p.x), static_cast<double>(p.y)));
  return pixels;
}

std::optional<Pixels> marker_corners(const cv::Mat& gray, const Intrinsics& camera, const DatasetTarget& target) {
  for (const auto& detection : MarkerDetector(target.dictionary).detect(gray, camera)) {
    if (detection.id != target.id) continue;
    Pixels pixels;
    for (const auto& p : detection.corners_px) pixels.push_back(Eigen::Vector2d(p.x, p.y));
    return pixels;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Pixels> corners_in_picture(const Dataset& dataset, const DatasetTarget& target,
                                         const std::string& picture) {
  const std::filesystem::path file = dataset.folder / "images" / picture;
  const cv::Mat gray = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (gray.empty()) throw ConfigError(file.string() + ": cannot be read as a picture");
  if (target.kind == TargetKind::kMarker) return marker_corners(gray, dataset.model.camera, target);
  return chessboard_corners(gray, target);
}

std::vector<Vector3> points_of(const DatasetTarget& target) {
  std::vector<Vector3> points;
  if (target.kind == TargetKind::kChessboard) {
    for (int r = 0; r < target.board_rows; ++r) {
      for (int c = 0; c < target.board_columns; ++c) points.push_back(target.square_m * Vector3(c, r, 0));
    }
    return points;
  }
  for (const Vector3& corner : marker_corners_M(target.side_m)) points.push_back(corner);
  return points;
}

bool start_pose_from_corners(const Intrinsics& camera, Observation& z) {
  if (z.points_M.size() < 4) return false;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (std::size_t k = 0; k < z.points_M.size(); ++k) {
    points.emplace_back(z.points_M[k].x(), z.points_M[k].y(), z.points_M[k].z());
    pixels.emplace_back(z.pixels[k].x(), z.pixels[k].y());
  }
  const cv::Mat K = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const cv::Mat distortion(5, 1, CV_64F, const_cast<double*>(camera.plumb_bob.data()));
  cv::Mat rotation_vector, t;
  try {
    if (!cv::solvePnP(points, pixels, K, distortion, rotation_vector, t)) return false;
  } catch (const cv::Exception&) {
    return false;  // points that span nothing
  }
  z.T_C_M = {
      so3_exp(Vector3(rotation_vector.at<double>(0), rotation_vector.at<double>(1), rotation_vector.at<double>(2))),
      Vector3(t.at<double>(0), t.at<double>(1), t.at<double>(2))};
  return is_finite(z.T_C_M) && z.T_C_M.p.z() > 0.0;
}

}  // namespace armsight::host
