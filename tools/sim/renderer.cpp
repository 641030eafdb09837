#include "tools/sim/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace armsight::sim {
namespace {

constexpr double kMoved_px = 2.0;      // a marker that moved so far on the picture is another look
constexpr double kSmear_px = 0.1;      // less motion is none, but to the markers, which stand exactly where they are

double largest_distance(const host::Corners& a, const host::Corners& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) largest = std::max(largest, std::hypot(a[i].x - b[i].x, a[i].y - b[i].y));
  return largest;
}

/// How far the world moves on the picture between two instants: hand and object, near their markers.
double smear_px(const WorldView& a, const WorldView& b, const host::Intrinsics& k) {
  const auto moved = [&](const Pose& from, const Pose& to, double side_m) {
    const auto p = project_corners(from, side_m, k), q = project_corners(to, side_m, k);
    return p && q ? largest_distance(*p, *q) : 0.0;
  };
  const double fingers = 60.0 * std::abs(a.hand_closure - b.hand_closure);
  return std::max(
      {moved(a.T_C_B * a.T_B_H, b.T_C_B * b.T_B_H, 0.2), moved(a.T_C_B * a.T_B_O, b.T_C_B * b.T_B_O, 0.1), fingers});
}

/// Steps of about a pixel are smooth behind the defocus: little motion needs few instants.
std::vector<WorldView> thinned(std::span<const WorldView> instants, double smear) {
  const std::size_t n = instants.size();
  if (n < 5 || smear > 2.5) return {instants.begin(), instants.end()};
  if (smear > 1.2) return {instants[0], instants[n / 2], instants[n - 1]};
  return {instants[n / 4], instants[n - 1 - n / 4]};
}

bool is_same(const Pose& a, const Pose& b) { return (a.p - b.p).norm() < 1e-5 && (a.R - b.R).norm() < 1e-5; }

}  // namespace

Renderer::Renderer(const Scene& scene, const MarkerConfig& hand_marker, const NoiseFigures& noise, std::uint64_t seed)
    : scene_(scene),
      noise_(noise),
      random_(seed),
      hand_marker_{hand_marker, host::marker_pattern(hand_marker.dictionary, hand_marker.id), {}, {}, {}},
      object_marker_{scene.object.marker,
                     host::marker_pattern(scene.object.marker.dictionary, scene.object.marker.id),
                     {},
                     {},
                     {}},
      caster_(scene.camera.intrinsics),
      optics_(scene.camera, scene.light, seed ^ 0x0B71C5) {
  still_T_C_B_.p.setConstant(1e9);  // nothing drawn yet
}

void Renderer::draw_shift(Marker& marker, const Pose& T_C_M) {
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma_px) {
    CornerShift shift;
    for (cv::Point2d& corner : shift) {
      corner.x = sigma_px * normal(random_);
      corner.y = sigma_px * normal(random_);
    }
    return shift;
  };
  const CornerShift bias = draw(noise_.corner_bias_px), white = draw(noise_.corner_px);  // drawn in any case: one order
  const auto corners = project_corners(T_C_M, marker.config.side_m, scene_.camera.intrinsics);
  if (corners && largest_distance(*corners, marker.bias_drawn_at) > kMoved_px) {
    marker.bias_px = bias;
    marker.bias_drawn_at = *corners;
  }
  for (std::size_t i = 0; i < 4; ++i) marker.shift_px[i] = marker.bias_px[i] + white[i];
}

std::shared_ptr<const MarkerPrint> Renderer::print(const Marker& marker, const Pose& T_C_M) const {
  auto made = MarkerPrint::make(marker.pattern, marker.config.side_m, T_C_M, scene_.camera.intrinsics, marker.shift_px);
  return made ? std::make_shared<const MarkerPrint>(*made) : nullptr;
}

Pose Renderer::T_C_object_marker(const WorldView& world) const {
  return world.T_C_B * world.T_B_O * Pose{Matrix3::Identity(), {0.0, 0.0, scene_.object.marker_height_m}};
}

Stage Renderer::stage_of(const WorldView& world) const {
  const Pose T_C_T = world.T_C_B * table_top(scene_, world.T_B_O);
  const auto& lamp = scene_.light.lamp_up_forward_right;
  Stage stage;
  stage.up = T_C_T.R.col(2);
  stage.lamp = (T_C_T.R * Vector3(lamp[2], lamp[1], lamp[0])).normalized();
  stage.T_T_C = T_C_T.inverse();
  stage.T_T_O = stage.T_T_C * world.T_C_B * world.T_B_O;
  stage.object_radius_m = scene_.object.radius_m;
  stage.object_half_height_m = 0.5 * scene_.object.height_m;
  return stage;
}

void Renderer::refresh_still_life(const WorldView& world) {
  if (is_same(world.T_C_B, still_T_C_B_) && is_same(world.T_B_O, still_T_B_O_)) return;
  const Stage stage = stage_of(world);
  Canvas room;
  caster_.draw_room(stage, room);
  std::vector<Shape> shapes;
  add_table(stage.T_T_C.inverse(), scene_.table, shapes);
  caster_.draw(stage, std::move(shapes), room, still_life_);
  still_T_C_B_ = world.T_C_B;
  still_T_B_O_ = world.T_B_O;
  is_drawn_ = false;
}

void Renderer::draw_instant(const WorldView& world) {
  refresh_still_life(world);
  const Pose T_C_H = world.T_C_B * world.T_B_H, T_C_M = T_C_H * world.T_H_M;
  const auto object_print = print(object_marker_, T_C_object_marker(world)), hand_print = print(hand_marker_, T_C_M);
  const bool has_prints = object_print && hand_print;
  if (is_drawn_ && has_prints && smear_px(world, drawn_, intrinsics()) < kSmear_px) {
    caster_.reprint(stage_of(world), {object_print, hand_print}, still_life_, canvas_);
    return;
  }
  std::vector<Shape> shapes;
  add_object(world.T_C_B * world.T_B_O, scene_.object, object_print, shapes);
  add_arm(world.T_C_B, world.T_B_H, shapes);
  add_hand(T_C_H, world.hand_closure, shapes);
  add_plate(T_C_M, scene_.hand_plate_side_m, hand_print, shapes);
  caster_.draw(stage_of(world), std::move(shapes), still_life_, canvas_);
  is_drawn_ = has_prints;
  drawn_ = world;
}

cv::Mat Renderer::render(std::span<const WorldView> instants) {
  const WorldView& middle = instants[instants.size() / 2];
  draw_shift(hand_marker_, middle.T_C_B * middle.T_B_H * middle.T_H_M);
  draw_shift(object_marker_, T_C_object_marker(middle));
  const double smear = smear_px(instants.front(), instants.back(), intrinsics());
  if (smear < kSmear_px) {
    draw_instant(middle);
    return optics_.develop(canvas_.grey);
  }
  const std::vector<WorldView> taken = thinned(instants, smear);
  cv::Mat sum = cv::Mat::zeros(intrinsics().height, intrinsics().width, CV_32FC1);
  for (const WorldView& world : taken) {
    draw_instant(world);
    cv::scaleAdd(canvas_.grey, 1.0 / static_cast<double>(taken.size()), sum, sum);
  }
  return optics_.develop(sum);
}

}  // namespace armsight::sim
