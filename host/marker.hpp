// ArUco markers in a picture: which, and where their corners are to a few hundredths of a pixel.
// OpenCV finds and names them; the corners are ours (edge_refine): OpenCV's own are 0.1–0.6 px off and make every
// marker look too far away. All calls of the aruco module, whose interface changed with 4.7, stay in marker.cpp.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/intrinsics.hpp"

namespace armsight::host {

/// Order (-h,h), (h,h), (h,-h), (-h,-h) in M (x right, y up, z out of the print): clockwise from the top left.
using Corners = std::array<cv::Point2d, 4>;

struct MarkerDetection {
  int id = 0;
  Corners corners_px;
  double edge_rms_px = 0.0;  ///< scatter of the edge points about the four lines; 0: OpenCV's corners were kept
};

class MarkerDetector {
 public:
  /// "DICT_4X4_50" …; throws ConfigError for a name that OpenCV does not know.
  explicit MarkerDetector(const std::string& dictionary);
  /// A dictionary of one's own: one text of side² '0'/'1' an id, row by row, 1 = white.
  MarkerDetector(int side_modules, const std::vector<std::string>& bits);
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;

  /// Every marker of the dictionary in the picture (gray or BGR), by rising id. `region` restricts the search.
  std::vector<MarkerDetection> detect(const cv::Mat& image, const Intrinsics& intrinsics,
                                      const std::optional<cv::Rect>& region = std::nullopt) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The print of a marker: (side + 2)² modules with the black border, row 0 on top, true = white. Throws ConfigError.
struct MarkerPattern {
  int modules = 0;
  std::vector<bool> is_white;
  bool at(int row, int column) const { return is_white[static_cast<std::size_t>(row * modules + column)]; }
};
MarkerPattern marker_pattern(const std::string& dictionary, int id);

}  // namespace armsight::host
