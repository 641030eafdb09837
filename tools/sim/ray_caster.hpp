// Solids → grey levels on a canvas, through the lens: one ray a pixel, more where two surfaces meet in it.
// A pixel's value is the mean over its area, so that edges lie where geometry puts them (to 0.02 px on a marker).
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "tools/sim/shading.hpp"

namespace armsight::sim {

struct Canvas {
  cv::Mat grey;   ///< CV_32FC1, linear grey levels
  cv::Mat depth;  ///< CV_32FC1, z in C of the surface; large where there is none
};

class RayCaster {
 public:
  explicit RayCaster(const host::Intrinsics& intrinsics);

  /// The room on the whole canvas.
  void draw_room(const Stage& stage, Canvas& canvas) const;
  /// Draws shapes over what the canvas holds, where they are nearer than its depth.
  void draw(const Stage& stage, const std::vector<Shape>& shapes, Canvas& canvas);

 private:
  struct Posed;
  struct Span { int begin = 0, end = 0; };
  struct Meeting {
    bool is_edge = false, has_print = false;
    std::array<int, 9> shapes{};
    int count = 0;
  };

  Vector3 ray(int row, int column) const;
  Vector3 ray(double sub_column, double sub_row, int row, int column) const;
  cv::Rect window_of(const Shape& shape) const;
  void find_nearest(const std::vector<Posed>& posed, const Canvas& canvas);
  Meeting meeting_at(int row, int column) const;
  double mean_over_pixel(const Stage& stage, const std::vector<Posed>& posed, const Canvas& canvas, int row, int column,
                         const Meeting& meeting) const;

  host::Intrinsics intrinsics_;
  cv::Mat rays_;            ///< CV_32FC2: undistorted x/z, y/z of every pixel's centre
  cv::Mat nearest_;         ///< CV_32FC1: depth of the nearest shape so far
  cv::Mat surface_;         ///< CV_16UC1: which smooth surface is nearest; 0: none of the shapes
  std::vector<Span> spans_; ///< columns touched, a row
};

}  // namespace armsight::sim
