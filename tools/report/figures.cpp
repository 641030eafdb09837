// The figures of the report: the calibration's and those of chapter 8 (8.4 to 8.7).
#include "tools/report/report.hpp"

namespace armsight::demo {

namespace {

constexpr const char* kWithout = "without filter";
constexpr const char* kWith = "with filter";

std::vector<std::string> numbered(std::size_t count) {
  std::vector<std::string> texts;
  for (std::size_t i = 1; i <= count; ++i) texts.push_back(std::to_string(i));
  return texts;
}

std::vector<double> counted(std::size_t count, double first = 0) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(first + static_cast<double>(i));
  return values;
}

Plot residual_plot(const Report& r, const char* title, const char* y_label, double CalibrationLook::*value,
                   double rms) {
  Plot plot{.title = title, .x_label = "look", .y_label = y_label, .starts_at_zero = true};
  Series used{.label = "used", .color = kBlue, .mark = Mark::kCircle, .has_line = false};
  Series left_out{.label = "left out", .color = kVermillion, .mark = Mark::kCross, .has_line = false};
  for (std::size_t i = 0; i < r.calibrate.looks.size(); ++i) {
    const CalibrationLook& look = r.calibrate.looks[i];
    Series& series = look.is_used ? used : left_out;
    series.x.push_back(static_cast<double>(i + 1));
    series.y.push_back(look.*value);
  }
  plot.series.push_back(used);
  if (!left_out.x.empty()) plot.series.push_back(left_out);
  plot.reference_y = rms;
  plot.reference_label = "RMS " + short_number(rms);
  return plot;
}

/// Two coordinates of the arm's points and of the commanded and true hands.
Plot pose_view(const Report& r, const char* title, const char* x_label, const char* y_label, int x, int y) {
  Plot plot{.title = title, .x_label = x_label, .y_label = y_label, .width_px = 520, .height_px = 440,
            .has_equal_axes = true, .is_y_down = y == 1};
  for (std::size_t i = 0; i < r.arm_in_camera.size(); ++i) {
    Series arm{
        .label = "pose " + std::to_string(i + 1), .color = series_color(i), .mark = Mark::kNone, .width_px = 2.5};
    for (const Vector3& p : r.arm_in_camera[i]) arm.x.push_back(p(x)), arm.y.push_back(p(y));
    plot.series.push_back(arm);
  }
  Series commanded{.label = "commanded", .color = kBlack, .mark = Mark::kRing, .has_line = false};
  Series without{.label = "reached without filter", .color = kVermillion, .mark = Mark::kCross, .has_line = false};
  Series with{.label = "reached with filter", .color = kBlack, .mark = Mark::kCircle, .has_line = false};
  for (const CommandedPose& p : r.with_filter) commanded.x.push_back(p.T_C_G.p(x)), commanded.y.push_back(p.T_C_G.p(y));
  for (const CommandedPose& p : r.without_filter) without.x.push_back(p.T_C_H.p(x)), without.y.push_back(p.T_C_H.p(y));
  for (const CommandedPose& p : r.with_filter) with.x.push_back(p.T_C_H.p(x)), with.y.push_back(p.T_C_H.p(y));
  for (const Series& s : {commanded, without, with}) plot.series.push_back(s);
  return plot;
}

Plot error_plot(const Report& r, const char* title, const char* y_label, double PoseError::*norm,
                PoseError CommandedPose::*error) {
  Plot plot{.title = title, .x_label = "commanded pose", .y_label = y_label, .groups = numbered(r.with_filter.size())};
  Bar without{.label = kWithout, .color = kVermillion}, with{.label = kWith, .color = kBlue};
  for (const CommandedPose& p : r.without_filter) without.heights.push_back(p.*error.*norm);
  for (const CommandedPose& p : r.with_filter) with.heights.push_back(p.*error.*norm);
  plot.bars = {without, with};
  return plot;
}

Plot action_plot(const Report& r, const char* title, const char* y_label, const char* symbol, double scale,
                 Vector3 AdaptLook::*value) {
  Plot plot{.title = title, .x_label = "looks", .y_label = y_label};
  for (int axis = 0; axis < 3; ++axis) {
    Series s{.label = std::string(symbol) + " " + "xyz"[axis],
             .x = {0},
             .y = {0},
             .color = series_color(static_cast<std::size_t>(axis)),
             .mark = series_mark(static_cast<std::size_t>(axis))};
    for (const AdaptLook& look : r.adapt.looks) {
      s.x.push_back(static_cast<double>(s.x.size()));
      s.y.push_back(scale * (look.*value)(axis));
    }
    plot.series.push_back(s);
  }
  return plot;
}

Plot offset_plot(const Report& r) {
  Plot plot{.title = "Joint offsets", .x_label = "looks", .y_label = "correction δβ [°]"};
  for (int joint = 0; joint < static_cast<int>(r.adapt.after.beta.size()); ++joint) {
    const auto at = static_cast<std::size_t>(joint);
    Series s{.label = "joint " + std::to_string(joint + 1),
             .x = {0},
             .y = {0},
             .color = series_color(at),
             .mark = series_mark(at)};
    for (const AdaptLook& look : r.adapt.looks) {
      s.x.push_back(static_cast<double>(s.x.size()));
      s.y.push_back(look.delta_beta(joint) / kDegree);
    }
    plot.series.push_back(s);
  }
  return plot;
}

Plot convergence_plot(const Report& r) {
  Plot plot{.title = "Error of the model", .x_label = "looks", .y_label = "position error at the commanded poses [mm]",
            .starts_at_zero = true};
  for (std::size_t i = 0; i < r.after_looks_mm_each.size(); ++i) {
    plot.series.push_back({.label = i == 0 ? "each pose" : "", .x = counted(r.after_looks_mm_each[i].size()),
                           .y = r.after_looks_mm_each[i], .color = kGrey, .mark = Mark::kNone, .width_px = 1.2});
  }
  Series median{.label = "median", .x = counted(r.after_looks.size()), .color = kBlue, .width_px = 2.5};
  for (const PoseError& e : r.after_looks) median.y.push_back(e.mm);
  plot.series.push_back(median);
  return plot;
}

Plot grasp_plot(const Report& r, const char* title, const char* x_label, const char* y_label, int x, int y) {
  Plot plot{.title = title, .x_label = x_label, .y_label = y_label, .width_px = 520, .height_px = 440,
            .circles = {{0, 0, 10, "10 mm: the grasp holds"}}, .has_equal_axes = true};
  const auto add = [&](const GraspEvaluation& g, const char* name, const char* color, Mark mark) {
    if (!g.was_closed) return;
    const double goal_x = 1e3 * g.T_G_computed.p(x), goal_y = 1e3 * g.T_G_computed.p(y);
    const double hand_x = 1e3 * g.T_G_reached.p(x), hand_y = 1e3 * g.T_G_reached.p(y);
    plot.series.push_back({.x = {goal_x, hand_x},
                           .y = {goal_y, hand_y},
                           .color = color,
                           .mark = Mark::kNone,
                           .is_dashed = true,
                           .width_px = 1.2});
    plot.series.push_back({.label = std::string("goal, ") + name,
                           .x = {goal_x},
                           .y = {goal_y},
                           .color = color,
                           .mark = Mark::kRing,
                           .has_line = false});
    plot.series.push_back({.label = std::string("hand, ") + name,
                           .x = {hand_x},
                           .y = {hand_y},
                           .color = color,
                           .mark = mark,
                           .has_line = false});
  };
  add(r.without_grasp, kWithout, kVermillion, Mark::kSquare);
  add(r.with_grasp, kWith, kBlue, Mark::kCircle);
  return plot;
}

}  // namespace

std::vector<Plot> calibration_figures(const Report& r) {
  return {residual_plot(r, "Position residual of each look", "residual [mm]", &CalibrationLook::residual_mm,
                        r.calibrate.training_mm),
          residual_plot(r, "Orientation residual of each look", "residual [°]", &CalibrationLook::residual_deg,
                        r.calibrate.training_deg)};
}

std::vector<Plot> commanded_pose_figures(const Report& r) {
  return {pose_view(r, "As the camera sees it", "x in the camera [m]", "y in the camera [m]", 0, 1),
          pose_view(r, "From above the camera", "x in the camera [m]", "z in the camera [m]", 0, 2)};
}

std::vector<Plot> error_figures(const Report& r) {
  return {error_plot(r, "Position error norm (5.17)", "model against truth [mm]", &PoseError::mm,
                     &CommandedPose::model_error),
          error_plot(r, "Orientation error norm (5.18)", "model against truth [°]", &PoseError::deg,
                     &CommandedPose::model_error),
          error_plot(r, "Reached against commanded, position", "true hand against command [mm]", &PoseError::mm,
                     &CommandedPose::reached_error),
          error_plot(r, "Reached against commanded, orientation", "true hand against command [°]", &PoseError::deg,
                     &CommandedPose::reached_error)};
}

std::vector<Plot> filter_figures(const Report& r) {
  return {convergence_plot(r),
          action_plot(r, "Camera position", "correction δt [mm]", "δt", 1e3, &AdaptLook::delta_t_m),
          action_plot(r, "Camera orientation", "correction δϑ [°]", "δϑ", 1.0 / kDegree, &AdaptLook::delta_theta_rad),
          offset_plot(r)};
}

std::vector<Plot> grasp_figures(const Report& r) {
  return {grasp_plot(r, "Along and across the forearm", "along x of the right grasp [mm]",
                     "along y of the right grasp [mm]", 0, 1),
          grasp_plot(r, "Across and along the object", "along x of the right grasp [mm]",
                     "along z of the right grasp [mm]", 0, 2)};
}

}  // namespace armsight::demo
