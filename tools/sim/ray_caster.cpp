#include "tools/sim/ray_caster.hpp"

#include <algorithm>
#include <cmath>

#include "tools/sim/printed_marker.hpp"

namespace armsight::sim {
namespace {

constexpr int kPrintSamples = 64;     // a pixel with a print's edge: 1/64 px steps even for edges along the rows
constexpr int kEdgeSamples = 8;

/// Surfaces of one shape: 8 plain parts and two tones of its print.
constexpr int kSurfaces = 16;
constexpr int kBlack = 8, kWhite = 9;

/// Sample i of n in the pixel, each coordinate taking n distinct values: Hammersley's points, about the centre.
double second_coordinate(int i, int n) {
  double value = 0.0, step = 0.5;
  for (int bits = i; bits > 0; bits >>= 1, step *= 0.5) value += (bits & 1) != 0 ? step : 0.0;
  return value + 0.5 / n - 0.5;
}
double first_coordinate(int i, int n) { return (i + 0.5) / n - 0.5; }

/// Print under the ray, if the point lies on the printed face.
std::optional<bool> module_at(const Shape& shape, int part, const Vector3& d_C) {
  if (!shape.print || part != kTop) return std::nullopt;
  return shape.print->is_white(d_C.x(), d_C.y());
}

std::uint16_t surface_number(const Shape& shape, std::size_t index, int part, const Vector3& d_C) {
  const auto module = module_at(shape, part, d_C);
  const int tone = module ? (*module ? kWhite : kBlack) : part;
  return static_cast<std::uint16_t>(1 + static_cast<int>(index) * kSurfaces + tone);
}

}  // namespace

double RayCaster::Posed::distance(const Vector3& d_C) const {
  if (shape.form != Form::kBox && d_C.dot(outline_C * d_C) < 0.0) return -1.0;
  return meet(shape, o_S, R_S_C * d_C);
}

void RayCaster::draw_room(const Stage& stage, Canvas& canvas) const {
  canvas.grey.create(rays_.size(), CV_32FC1);
  canvas.depth.create(rays_.size(), CV_32FC1);
  canvas.depth.setTo(1e9);
  for (int row = 0; row < rays_.rows; ++row) {
    for (int column = 0; column < rays_.cols; ++column) {
      canvas.grey.at<float>(row, column) = static_cast<float>(shade_room(stage, ray(row, column)));
    }
  }
}

void RayCaster::find_nearest(const Canvas& background) {
  background.depth.copyTo(nearest_);
  surface_.setTo(0);
  for (std::size_t i = 0; i < posed_.size(); ++i) {
    const Posed& p = posed_[i];
    for (int row = p.window.y; row < p.window.br().y; ++row) {
      float* nearest = nearest_.ptr<float>(row);
      std::uint16_t* surface = surface_.ptr<std::uint16_t>(row);
      for (int column = p.window.x; column < p.window.br().x; ++column) {
        const Vector3 d = ray(row, column);
        const double t = p.distance(d);
        if (!(t > kNear) || t >= static_cast<double>(nearest[column])) continue;
        nearest[column] = static_cast<float>(t);
        surface[column] = surface_number(p.shape, i, part_of(p.shape, p.point(d, t)), d);
      }
    }
  }
}

void RayCaster::list_printed() {
  printed_.clear();
  for (std::size_t i = 0; i < posed_.size(); ++i) {
    const cv::Rect& window = posed_[i].window;
    for (int row = window.y; posed_[i].shape.print && row < window.br().y; ++row) {
      for (int column = window.x; column < window.br().x; ++column) {
        const Meeting meeting = meeting_at(row, column);
        const auto end = meeting.shapes.begin() + meeting.count;
        if (std::find(meeting.shapes.begin(), end, static_cast<int>(i)) != end) printed_.emplace_back(column, row);
      }
    }
  }
}

/// Do the pixel and its eight neighbours show one surface? Asked for every pixel, so without a branch too many.
bool RayCaster::is_uniform(int row, int column) const {
  if (row == 0 || column == 0 || row + 1 == surface_.rows || column + 1 == surface_.cols) return false;
  const std::uint16_t* line = surface_.ptr<std::uint16_t>(row) + column;
  const std::ptrdiff_t down = surface_.cols;
  unsigned difference = 0;
  for (const std::ptrdiff_t at :
       {-down - 1, -down, -down + 1, std::ptrdiff_t{-1}, std::ptrdiff_t{1}, down - 1, down, down + 1}) {
    difference |= static_cast<unsigned>(line[at] ^ line[0]);
  }
  return difference == 0;
}

/// What can be met inside the pixel: the surfaces nearest at its centre and at its eight neighbours'.
RayCaster::Meeting RayCaster::meeting_at(int row, int column) const {
  Meeting meeting;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, surface_.rows - 1); ++r) {
    const std::uint16_t* line = surface_.ptr<std::uint16_t>(r);
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, surface_.cols - 1); ++c) {
      if (line[c] == 0) continue;
      meeting.has_print = meeting.has_print || (line[c] - 1) % kSurfaces >= kBlack;
      const int shape = (line[c] - 1) / kSurfaces;
      const auto end = meeting.shapes.begin() + meeting.count;
      if (std::find(meeting.shapes.begin(), end, shape) == end)
        meeting.shapes[static_cast<std::size_t>(meeting.count++)] = shape;
    }
  }
  return meeting;
}

double RayCaster::mean_over_pixel(const Stage& stage, const Canvas& background, int row, int column,
                                  const Meeting& meeting) const {
  const int samples = meeting.has_print ? kPrintSamples : kEdgeSamples;
  double sum = 0.0;
  for (int i = 0; i < samples; ++i) {
    const Vector3 d = ray(first_coordinate(i, samples), second_coordinate(i, samples), row, column);
    double nearest = static_cast<double>(background.depth.at<float>(row, column));
    const Posed* hit = nullptr;
    for (int c = 0; c < meeting.count; ++c) {
      const Posed& candidate = posed_[static_cast<std::size_t>(meeting.shapes[static_cast<std::size_t>(c)])];
      const double t = candidate.distance(d);
      if (t > kNear && t < nearest) {
        nearest = t;
        hit = &candidate;
      }
    }
    if (hit == nullptr) {
      sum += static_cast<double>(background.grey.at<float>(row, column));
      continue;
    }
    const Vector3 p_S = hit->point(d, nearest);
    const int part = part_of(hit->shape, p_S);
    sum += shade(stage, hit->shape, nearest * d, p_S, part, module_at(hit->shape, part, d));
  }
  return sum / samples;
}

void RayCaster::shade_pixel(const Stage& stage, const Canvas& background, int row, int column, float& grey) const {
  const int surface = surface_.at<std::uint16_t>(row, column);
  if (!is_uniform(row, column)) {
    grey = static_cast<float>(mean_over_pixel(stage, background, row, column, meeting_at(row, column)));
  } else if (surface != 0) {
    const Posed& p = posed_[static_cast<std::size_t>((surface - 1) / kSurfaces)];
    const Vector3 d = ray(row, column);
    const double t = static_cast<double>(nearest_.at<float>(row, column));
    const int tone = (surface - 1) % kSurfaces, part = tone >= kBlack ? kTop : tone;
    const std::optional<bool> module = tone >= kBlack ? std::optional<bool>(tone == kWhite) : std::nullopt;
    grey = static_cast<float>(shade(stage, p.shape, t * d, p.point(d, t), part, module));
  }
}

void RayCaster::draw(const Stage& stage, std::vector<Shape> shapes, const Canvas& background, Canvas& canvas) {
  background.grey.copyTo(canvas.grey);
  place(std::move(shapes));
  find_nearest(background);
  for (int row = 0; row < rays_.rows; ++row) {
    const Span& span = spans_[static_cast<std::size_t>(row)];
    float* grey = canvas.grey.ptr<float>(row);
    for (int column = span.begin; column < span.end; ++column)
      shade_pixel(stage, background, row, column, grey[column]);
  }
  nearest_.copyTo(canvas.depth);
  list_printed();
}

void RayCaster::reprint(const Stage& stage, const std::vector<std::shared_ptr<const MarkerPrint>>& prints,
                        const Canvas& background, Canvas& canvas) {
  auto next = prints.begin();
  for (Posed& p : posed_) {
    if (p.shape.print && next != prints.end()) p.shape.print = *next++;
  }
  for (const cv::Point& at : printed_) {
    std::uint16_t& surface = surface_.at<std::uint16_t>(at);
    if (surface == 0) continue;
    const std::size_t index = static_cast<std::size_t>((surface - 1) / kSurfaces);
    const Posed& p = posed_[index];
    if (!p.shape.print) continue;
    const int tone = (surface - 1) % kSurfaces;
    surface = surface_number(p.shape, index, tone >= kBlack ? kTop : tone, ray(at.y, at.x));
  }
  for (const cv::Point& at : printed_) shade_pixel(stage, background, at.y, at.x, canvas.grey.at<float>(at));
}

}  // namespace armsight::sim
