// report.html: one file that needs nothing else. Order: the result, then each phase with its figures and pictures,
// then what is needed to repeat it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tools/report/base64.hpp"
#include "tools/report/report.hpp"
#include "tools/report/report_style.hpp"

namespace armsight::demo {

namespace {

std::string n(double value, int digits = 3) { return short_number(value, digits); }
std::string n(const std::optional<double>& value) { return short_number(value.value_or(std::nan(""))); }

/// With its unit's fixed decimals, for figures that are read side by side.
std::string fixed(double value, int decimals) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string in_mm_and_deg(double mm, double deg) { return fixed(mm, mm < 10 ? 2 : 1) + " mm, " + fixed(deg, 2) + "°"; }

std::string tile(const std::string& name, const std::string& value, const std::string& below, const char* color = "") {
  return "<div class=\"tile\"><span class=\"name\">" + name + "</span><b class=\"" + color + "\">" + value +
         "</b><span>" + below + "</span></div>";
}

std::string figures(const std::vector<Plot>& plots) {
  std::string out = "<div class=\"figures\">";
  for (const Plot& plot : plots) out += "<figure>" + to_svg(plot) + "</figure>";
  return out + "</div>";
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string out = "<tr>";
  for (const std::string& cell : cells)
    out += std::string("<") + tag + (cell.size() > 24 && &cell != &cells.front() ? " class=\"text\">" : ">") + cell +
           "</" + tag + ">";
  return out + "</tr>";
}

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<div class=\"scroll\"><table><thead>" + row(head, "th") + "</thead><tbody>";
  for (const auto& cells : rows) out += row(cells);
  return out + "</tbody></table></div>";
}

std::string images(const Report& r, const std::string& phase) {
  std::string out;
  for (const ReportImage& image : r.images) {
    if (!image.caption.starts_with(phase)) continue;
    const bool is_png = image.file.extension() == ".png";
    out += "<figure><img alt=\"" + escape_html(image.caption) + "\" src=\"data:image/" + (is_png ? "png" : "jpeg") +
           ";base64," + base64_of_file(image.file) + "\"><figcaption>" + escape_html(image.caption) +
           "</figcaption></figure>";
  }
  return out.empty() ? out : "<div class=\"figures\">" + out + "</div>";
}

double median_of(const std::vector<CommandedPose>& poses, double PoseError::*norm) {
  std::vector<double> values;
  for (const CommandedPose& p : poses) values.push_back(p.model_error.*norm);
  return median(values);
}

std::string grasp_words(const GraspEvaluation& g) {
  if (!g.was_closed) return "not attempted";
  return in_mm_and_deg(g.error.mm, g.error.deg);
}

std::string head(const Report& r) {
  const std::string verdict =
      r.with_grasp.is_success ? "The hand holds the object." : "The hand does not hold the object.";
  std::string out =
      "<header><div><h1>Armsight: " + verdict + "</h1><p class=\"soft\">Robot " + escape_html(r.robot_name) +
      ", seed " + std::to_string(r.seed) + ", noise set " + r.noise + ", pace " + r.pace + ". " +
      escape_html(r.bus_line) +
      ". Every error is measured against the simulator's truth, which the programs never saw.</p><div class=\"tiles\">";
  out += tile("Learn: held out", in_mm_and_deg(r.heldout.rms_mm, r.heldout.rms_deg),
              "RMS over " + std::to_string(r.heldout.postures) + " postures never looked at");
  out += tile("Drift, no filter",
              in_mm_and_deg(median_of(r.without_filter, &PoseError::mm), median_of(r.without_filter, &PoseError::deg)),
              "median of the commanded poses", "bad");
  out += tile("Adapt: with filter",
              in_mm_and_deg(median_of(r.with_filter, &PoseError::mm), median_of(r.with_filter, &PoseError::deg)),
              "the same poses after " + std::to_string(r.adapt.looks.size()) + " looks", "good");
  out += tile("Act: without filter", r.without_grasp.is_success ? "held" : "missed", grasp_words(r.without_grasp),
              r.without_grasp.is_success ? "good" : "bad");
  out += tile("Act: with filter", r.with_grasp.is_success ? "held" : "missed", grasp_words(r.with_grasp),
              r.with_grasp.is_success ? "good" : "bad");
  return out + "</div></div></header>";
}

std::string calibration_section(const Report& r) {
  const CalibrateResult& c = r.calibrate;
  const auto used = std::ranges::count_if(c.looks, &CalibrationLook::is_used);
  std::string out =
      "<h2>Learn: calibration</h2><p>The host found the hand marker, drove the arm through postures that it planned "
      "itself, and "
      "solved for the camera's pose and the joint offsets from " +
      std::to_string(used) + " of " + std::to_string(c.looks.size()) + " looks.</p>" + figures(calibration_figures(r));
  out += table({"hand pose error", "position [mm]", "orientation [°]"},
               {{"residual on the looks used (RMS)", n(c.training_mm), n(c.training_deg)},
                {"looks left out in turn, against the camera (RMS)", n(c.crossvalidation_mm), n(c.crossvalidation_deg)},
                {"held-out postures, against the truth (RMS)", n(r.heldout.rms_mm), n(r.heldout.rms_deg)}});
  out += "<h3>What can be known</h3><p>" + std::to_string(c.rank) + " of " + std::to_string(c.parameters) +
         " parameters are observable from these looks.</p><ul>";
  for (const std::string& sentence : c.unobservable) out += "<li>" + escape_html(sentence) + "</li>";
  out += "</ul><h3>Parameters after gauge alignment</h3>";
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < r.parameters.beta_error_deg.size(); ++i) {
    rows.push_back({"offset of joint " + std::to_string(i + 1) + " [°]",
                    n(kDegrees * c.model.beta(static_cast<Eigen::Index>(i))),
                    i < c.sigma_beta_deg.size() ? n(c.sigma_beta_deg[i]) : "–", n(r.parameters.beta_error_deg[i])});
  }
  rows.push_back({"camera position [mm]", "", n(c.sigma_camera_mm), n(r.parameters.camera.mm)});
  rows.push_back({"camera orientation [°]", "", n(c.sigma_camera_deg), n(r.parameters.camera.deg)});
  out += table({"parameter", "learnt", "stated σ", "error against the truth"}, rows);
  return out + images(r, "Learn");
}

std::string adapt_section(const Report& r) {
  std::string out =
      "<h2>Adapt: the filter</h2><p>Then the robot drifted: the camera turned and moved, every joint offset changed. "
      "Fig. 8.4 shows the "
      "five commanded poses; all figures use the true camera.</p><h3>Fig. 8.4: the commanded poses</h3>" +
      figures(commanded_pose_figures(r)) +
      "<h3>Fig. 8.5: error norms with and without filter</h3><p>Upper row: the model's hand pose at the encoder "
      "reading against the "
      "true one at the same instant. Lower row: the true hand against the commanded pose, which adds the drives' own "
      "error.</p>" +
      figures(error_figures(r)) + "<h3>Fig. 8.6: the filter's action</h3>" + figures(filter_figures(r));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < r.adapt.looks.size(); ++i) {
    const AdaptLook& look = r.adapt.looks[i];
    rows.push_back({std::to_string(i + 1), escape_html(look.outcome), n(1e3 * look.innovation.head<3>().norm()),
                    n(kDegrees * look.innovation.tail<3>().norm()), n(look.nis), n(look.cost), n(look.gain_norm),
                    std::to_string(look.iterations)});
  }
  out += table({"look", "outcome", "innovation [mm]", "[°]", "NIS", "cost", "gain norm", "iterations"}, rows);
  return out + images(r, "Adapt");
}

std::string grasp_section(const Report& r) {
  std::string out =
      "<h2>Act: the grasp</h2><h3>Fig. 8.7: computed goal and final hand pose</h3><p>Seen from the nearest right grasp "
      "(the origin). "
      "Rings are the goals that the host computed from the object's marker, filled marks the true hand when it "
      "closed.</p>" +
      figures(grasp_figures(r));
  const auto line = [](const char* name, const GraspResult& result, const GraspEvaluation& g) {
    return std::vector<std::string>{name,
                                    g.was_closed ? n(g.error.mm) : "–",
                                    g.was_closed ? n(g.error.deg) : "–",
                                    escape_html(result.verdict),
                                    g.is_success ? "held" : "not held",
                                    g.does_verdict_agree ? "yes" : "no",
                                    escape_html(result.why)};
  };
  out += table(
      {"", "error [mm]", "error [°]", "host's verdict", "truth", "agree", "why"},
      {line("without filter", r.grasp_without, r.without_grasp), line("with filter", r.grasp_with, r.with_grasp)});
  return out + images(r, "Act");
}

std::string controller_section(const Report& r) {
  const ControllerFigures& c = r.controller;
  std::string out = "<h2>The controller's cycles</h2><p>" + n(c.rate_hz) + " Hz, " + std::to_string(c.cycles) +
                    " cycles, " + std::to_string(c.missed) + " missed. " +
                    (c.black_boxes.empty() ? "No watchdog fired."
                                           : std::to_string(c.black_boxes.size()) + " watchdogs fired.") +
                    "</p>" + figures(controller_figures(r));
  std::vector<std::vector<std::string>> rows;
  for (const DurationRow& d : c.durations)
    rows.push_back({escape_html(d.name), std::to_string(d.count), n(d.p50_us), n(d.p999_us), n(d.max_us)});
  return out + table({"duration", "count", "median [µs]", "99.9 % [µs]", "longest [µs]"}, rows);
}

std::string repeat_section(const Report& r) {
  std::vector<std::vector<std::string>> phases, programs;
  for (const Phase& p : r.phases) phases.push_back({escape_html(p.name), fixed(p.simulated_s, 1), fixed(p.wall_s, 1)});
  for (const auto& [name, version] : r.versions) programs.push_back({name, escape_html(version)});
  std::string out = "<h2>Time</h2>" + table({"phase", "robot's time [s]", "wall time [s]"}, phases);
  out += "<p>The calibration was solved in " + n(r.calibrate.solve_wall_ms) + " ms.</p>";
  out += "<h2>To repeat this run</h2><p><code>./tools/demo --seed " + std::to_string(r.seed) + " --noise " + r.noise +
         " --pace " + r.pace + "</code></p>" + table({"program", "version"}, programs);
  std::string commands;
  for (const std::string& c : r.commands) commands += c + "\n";
  out += "<details><summary>The command lines</summary><pre>" + escape_html(commands) + "</pre></details>";
  for (const auto& [name, text] : r.inputs) {
    out += "<details><summary>" + escape_html(name) + "</summary><pre>" + escape_html(text) + "</pre></details>";
  }
  return out;
}

}  // namespace

std::string to_html(const Report& r) {
  return std::string(
             "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
             "content=\"width=device-width,initial-scale=1\"><title>Armsight: demo report</title><style>") +
         kReportStyle + "</style></head><body>" + head(r) + "<main>" + calibration_section(r) + adapt_section(r) +
         grasp_section(r) + controller_section(r) + repeat_section(r) +
         "</main><footer><div>report.json beside this file holds the same figures for "
         "programs.</div></footer></body></html>\n";
}

}  // namespace armsight::demo
