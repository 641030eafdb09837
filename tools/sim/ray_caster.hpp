// Solids → grey levels on a canvas, through the lens: one ray a pixel, more where two surfaces meet in it.
// A pixel's value is the mean over its area, so that edges lie where geometry puts them (to 0.02 px on a marker).
#pragma once

#include <array>
#include <memory>
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
  /// The background with the shapes before it, where they are nearer than its depth. The shapes are kept for reprint().
  void draw(const Stage& stage, std::vector<Shape> shapes, const Canvas& background, Canvas& canvas);
  /// The picture of the last draw() with other prints on its shapes (in their order): only printed faces cost anything.
  void reprint(const Stage& stage, const std::vector<std::shared_ptr<const MarkerPrint>>& prints,
               const Canvas& background, Canvas& canvas);

 private:
  static constexpr double kNear = 0.03;  ///< m, what is nearer is not drawn

  struct Posed {
    Shape shape;
    Matrix3 R_S_C;
    Vector3 o_S;        ///< the camera in S
    cv::Rect window;
    Matrix3 outline_C;  ///< dᵀQd < 0: the ray passes the endless tube about z_S (b² − ac of its quadratic equation)

    double distance(const Vector3& d_C) const;
    Vector3 point(const Vector3& d_C, double t) const { return o_S + t * (R_S_C * d_C); }
  };
  struct Span { int begin = 0, end = 0; };
  struct Meeting {
    bool has_print = false;
    std::array<int, 9> shapes{};
    int count = 0;
  };

  Vector3 ray(int row, int column) const;
  Vector3 ray(double sub_column, double sub_row, int row, int column) const;
  cv::Rect window_of(const Shape& shape) const;
  void place(std::vector<Shape> shapes);
  void find_nearest(const Canvas& background);
  void list_printed();
  bool is_uniform(int row, int column) const;
  Meeting meeting_at(int row, int column) const;
  double mean_over_pixel(const Stage& stage, const Canvas& background, int row, int column,
                         const Meeting& meeting) const;
  void shade_pixel(const Stage& stage, const Canvas& background, int row, int column, float& grey) const;

  host::Intrinsics intrinsics_;
  cv::Mat rays_;                     ///< CV_32FC2: undistorted x/z, y/z of every pixel's centre
  std::vector<Posed> posed_;         ///< shapes of the last draw that are in view
  cv::Mat nearest_;                  ///< CV_32FC1: depth of the nearest shape so far
  cv::Mat surface_;                  ///< CV_16UC1: which smooth surface is nearest; 0: none of the shapes
  std::vector<Span> spans_;          ///< columns touched, a row
  std::vector<cv::Point> printed_;   ///< pixels that show printed shapes, and their neighbours
};

}  // namespace armsight::sim
