// What `host calibrate --dataset` says: text for people, JSON for programs.
#include <cmath>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <ostream>

#include "host/learn_dataset.hpp"

namespace armsight::host {
namespace {

using Json = nlohmann::ordered_json;

std::string two_columns(const ErrorStatistics& s, bool has_pixels) {
  char text[160];
  if (has_pixels) {
    std::snprintf(text, sizeof text, "%7.2f px  %7.2f mm %6.3f deg", s.rms_px, s.rms_mm, s.rms_deg);
  } else {
    std::snprintf(text, sizeof text, "rms %7.3f mm %7.3f deg, median %7.3f mm %6.3f deg", s.rms_mm, s.rms_deg,
                  s.median_mm, s.median_deg);
  }
  return text;
}

Json to_json(const Pose& T) {
  const Eigen::Quaterniond quat(T.R);
  return {{"p_m", {T.p.x(), T.p.y(), T.p.z()}}, {"q_wxyz", {quat.w(), quat.x(), quat.y(), quat.z()}}};
}

Json to_json(const ErrorStatistics& s) {
  return {{"looks", s.looks},           {"rms_mm", s.rms_mm},         {"rms_deg", s.rms_deg}, {"mean_mm", s.mean_mm},
          {"median_mm", s.median_mm},   {"median_deg", s.median_deg}, {"p95_mm", s.p95_mm},   {"p95_deg", s.p95_deg},
          {"rms_px", s.rms_px},         {"robust_norm", s.robust_norm}};
}

bool has_pixels(const DatasetCalibration& result) { return !result.looks.empty() && result.looks[0].has_corners(); }

void print_pose(const char* what, const PoseUnknown& pose, std::ostream& out) {
  const Eigen::Quaterniond quat(pose.value.R);
  out << "  " << what << pose.name << ": p " << pose.value.p.transpose() << " m, quaternion wxyz " << quat.w() << ' '
      << quat.x() << ' ' << quat.y() << ' ' << quat.z() << (pose.freedom == Freedom::kFixed ? "  (fixed)" : "") << '\n';
}

void print_model(const DatasetCalibration& result, std::ostream& out) {
  const ChainModel& model = result.solution.model;
  out << std::setprecision(6) << "Result:\n";
  print_pose("", model.T_C_a, out);
  for (const auto& target : model.targets) print_pose("", target.T_b_M, out);
  for (const auto& [name, sigma] : result.sigma) {
    const bool is_offset = name.rfind("offset", 0) == 0;
    double value = 0.0;
    for (const auto& offset : model.offsets) value = name == "offset of " + offset.name ? offset.value : value;
    for (const auto& target : model.targets) value = name == "scale of " + target.name ? target.scale.value : value;
    char text[200];
    std::snprintf(text, sizeof text, is_offset ? "  %s: %+.3f deg, sigma %.3f deg\n" : "  %s: %.4f, sigma %.4f\n",
                  name.c_str(), is_offset ? value / kDegree : value, is_offset ? sigma / kDegree : sigma);
    out << text;
  }
}

}  // namespace

std::optional<double> offsets_alone_change(const DatasetCalibration& result) {
  const BlocksTried& mounts = result.choice.tried[0];
  for (const auto& tried : result.choice.tried) {
    if (name_of(tried.blocks) != "+ offsets" || tried.heldout_norm.empty()) continue;
    return compared_norm(tried, mounts) / compared_norm(mounts, mounts) - 1.0;
  }
  return std::nullopt;
}

std::string offsets_alone_in_words(const DatasetCalibration& result) {
  const auto change = offsets_alone_change(result);
  if (!change || *change < 0.0) return {};
  char text[200];
  std::snprintf(text, sizeof text, "Joint offsets alone lower the error of the looks learnt from and make looks never"
                " seen %.1f %% worse: not taken", 100.0 * *change);
  return text;
}

void print_calibration(const Dataset& dataset, const DatasetCalibration& result, std::ostream& out) {
  out << "Data set " << dataset.name << ": " << dataset.rows << " looks read, " << result.looks.size()
      << " used for learning and testing\n";
  if (result.time_offset_s)
    out << "Clocks: t_arm = t_look + " << std::fixed << std::setprecision(4) << *result.time_offset_s << " s, sigma "
        << std::setprecision(5) << result.time_offset_sigma_s << " s\n"
        << std::defaultfloat;
  out << "Left out by the chosen model: " << result.left_out.size() << '\n';
  for (const auto& look : result.left_out) out << "  " << look.label << ": " << look.reason << '\n';
  out << "Models (" << dataset.folds << "-fold over looks, outliers counted):\n";
  for (std::size_t i = 0; i < result.choice.tried.size(); ++i) {
    const BlocksTried& c = result.choice.tried[i];
    out << (i == result.choice.chosen ? "* " : "  ") << std::left << std::setw(18) << name_of(c.blocks)
        << std::right << std::setw(3)
        << c.unknowns << " unknowns\n      training " << two_columns(c.training, has_pixels(result))
        << "\n      held-out " << two_columns(c.heldout, has_pixels(result)) << '\n';
  }
  out << "Chosen by held-out error: " << name_of(result.chosen().blocks) << '\n';
  if (!offsets_alone_in_words(result).empty()) out << offsets_alone_in_words(result) << '\n';
  out << "Observability: rank " << result.rank << " of " << result.parameters << '\n';
  for (const auto& sentence : result.unobservable) out << "  " << sentence << '\n';
  print_model(result, out);
}

std::string calibration_json(const Dataset& dataset, const DatasetCalibration& result) {
  const ChainModel& model = result.solution.model;
  Json json{{"dataset", dataset.name}, {"rows", dataset.rows}, {"looks", result.looks.size()}};
  if (result.time_offset_s) {
    json["time_offset_s"] = *result.time_offset_s;
    json["time_offset_sigma_s"] = result.time_offset_sigma_s;
  }
  json["left_out"] = Json::array();
  for (const auto& look : result.left_out) json["left_out"].push_back({{"row", look.label}, {"reason", look.reason}});
  json["candidates"] = Json::array();
  for (const auto& c : result.choice.tried) {
    json["candidates"].push_back({{"name", name_of(c.blocks)}, {"unknowns", c.unknowns},
                                  {"training", to_json(c.training)},
                                  {"heldout", to_json(c.heldout)}});
  }
  json["chosen"] = name_of(result.chosen().blocks);
  json["rank"] = result.rank;
  json["parameters"] = result.parameters;
  json["unobservable"] = result.unobservable;
  json["camera"] = to_json(model.T_C_a.value);
  json["targets"] = Json::object();
  for (const auto& target : model.targets) {
    json["targets"][target.name] = {{"mount", to_json(target.T_b_M.value)}, {"scale", target.scale.value}};
  }
  json["beta_rad"] = Json::object();
  for (const auto& offset : model.offsets) json["beta_rad"][offset.name] = offset.value;
  json["sigma"] = Json::object();
  for (const auto& [name, sigma] : result.sigma)
    json["sigma"][name] = std::isfinite(sigma) ? Json(sigma) : Json(nullptr);
  json["solve_wall_s"] = result.solve_wall_s;
  return json.dump(2) + "\n";
}

LearnCost learn_cost(const std::string& name) {
  if (name == "poses") return LearnCost::kPoses;
  if (name == "pixels") return LearnCost::kPixels;
  return name == "thesis" ? LearnCost::kThesis : LearnCost::kLikelihood;
}

int run_calibrate_dataset(const std::filesystem::path& folder, const std::filesystem::path& out_file, LearnCost cost,
                          std::ostream& out) {
  const Dataset dataset = load_dataset(folder);
  if (dataset.observations.size() < 6) {
    out << "calibrate: " << dataset.observations.size() << " usable looks: at least 6 are needed; add looks\n";
    return 1;
  }
  DatasetOptions options;
  options.cost = cost;
  const DatasetCalibration result = calibrate_dataset(dataset, options);
  print_calibration(dataset, result, out);
  if (out_file.empty()) return 0;
  std::ofstream file(out_file);
  file << calibration_json(dataset, result);
  if (!file.flush()) throw ConfigError(out_file.string() + ": cannot be written");
  out << "Written: " << out_file.string() << '\n';
  return 0;
}

}  // namespace armsight::host
