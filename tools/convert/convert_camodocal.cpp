// camodocal-arm-artag: pairs of matrices, T1 the arm's tip in the base, T2 the tag in the camera; no joints.
#include <map>

#include "tools/convert/text_files.hpp"

namespace armsight::tools {
namespace {

constexpr const char* kYaml = R"(dataset: camodocal-arm-artag
chains:
  - {name: arm, given: true}      # hand_t11 … hand_t34: the arm's tip in its base
camera: {on: root}
targets:
  - {name: tag, on: arm, kind: pose}
noise: {sigma_m: 0.003, sigma_rad: 0.0087}
)";

/// The 16 numbers after "data: [", possibly over several lines; returns the first 12 after checking the last row.
std::vector<std::string> matrix_rows(const std::vector<std::string>& lines, std::size_t from, const Path& file) {
  std::string text;
  std::size_t i = from;
  while (i < lines.size() && lines[i].find("data:") == std::string::npos) ++i;
  const std::size_t first = i;
  for (; i < lines.size(); ++i) {
    text += " " + lines[i];
    if (lines[i].find(']') != std::string::npos) break;
  }
  const auto open = text.find('['), close = text.find(']');
  if (open == std::string::npos || close == std::string::npos) refuse(file, first + 1, "data: [ … ] is missing");
  auto numbers = split(std::string_view(text).substr(open + 1, close - open - 1), ',');
  for (const auto& number : numbers) checked_number(number, file, first + 1);
  if (numbers.size() != 16 || std::stod(numbers[12]) != 0 || std::stod(numbers[13]) != 0 ||
      std::stod(numbers[14]) != 0 || std::stod(numbers[15]) != 1) {
    refuse(file, first + 1, "must be a 4 x 4 pose with the last row 0 0 0 1");
  }
  numbers.resize(12);
  return numbers;
}

std::string matrix_header(const std::string& prefix) {
  std::string text;
  for (int r = 1; r <= 3; ++r) {
    for (int c = 1; c <= 4; ++c) text += "," + prefix + "t" + std::to_string(r) + std::to_string(c);
  }
  return text;
}

}  // namespace

int convert_camodocal(const Path& source, const Path& target) {
  const Path file = source / "TransformPairsInput.yml";
  const auto lines = read_lines(file);
  std::map<int, std::vector<std::string>> arm, tag;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (auto [prefix, poses] : {std::pair{"T1_", &arm}, std::pair{"T2_", &tag}}) {
      if (lines[i].rfind(prefix, 0) == 0) (*poses)[std::stoi(lines[i].substr(3))] = matrix_rows(lines, i, file);
    }
  }
  if (arm.empty() || arm.size() != tag.size()) refuse(file, 1, "must hold as many T1_k as T2_k");
  std::string rows = "marker" + matrix_header("hand_") + matrix_header("") + "\n";
  for (const auto& [k, pose] : arm) {
    if (tag.count(k) == 0) refuse(file, 1, "T2_" + std::to_string(k) + ": is missing");
    rows += "tag," + join(pose) + "," + join(tag[k]) + "\n";
  }
  write_file(target / "samples.csv", rows);
  write_file(target / "dataset.yaml", kYaml);
  return static_cast<int>(arm.size());
}

}  // namespace armsight::tools
