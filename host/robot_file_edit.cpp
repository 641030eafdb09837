#include "host/robot_file_edit.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

struct Edit {
  std::size_t at = 0, length = 0;
  std::string text;
};

/// Shortest text that reads back as this very number.
std::string exact(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value == 0.0 ? 0.0 : value).ptr;
  return {text, end};
}

class DriveEditor {
 public:
  DriveEditor(const std::string& text, const YamlValue& drive) : text_(text), drive_(drive) {
    is_flow_ = text_[offset_of(drive)] == '{';
  }

  void set(const std::string& key, const std::string& value) {
    const YamlValue old = drive_.optional_key(key);
    if (!old.exists()) return insert(key, value);
    const std::size_t at = offset_of(old);
    edits_.push_back({at, text_.find_first_of(",} \t\r\n#", at) - at, value});
  }
  const std::vector<Edit>& edits() const { return edits_; }

 private:
  std::size_t offset_of(const YamlValue& value) const {
    std::size_t at = 0;
    for (int line = 1; line < value.line(); ++line) at = text_.find('\n', at) + 1;
    return at + static_cast<std::size_t>(value.column() - 1);
  }

  /// Behind the sign, which every drive has.
  void insert(const std::string& key, const std::string& value) {
    const std::size_t sign = offset_of(drive_.key("sign"));
    const std::size_t end = text_.find_first_of(",} \t\r\n#", sign);
    if (is_flow_) return edits_.push_back({end, 0, ", " + key + ": " + value});
    const std::size_t line = text_.rfind('\n', sign) + 1;
    const std::string indent = text_.substr(line, text_.find_first_not_of(' ', line) - line);
    edits_.push_back({std::min(text_.find('\n', sign), text_.size()), 0, "\n" + indent + key + ": " + value});
  }

  const std::string& text_;
  YamlValue drive_;
  bool is_flow_ = true;
  std::vector<Edit> edits_;
};

std::string apply(std::string text, std::vector<Edit> edits) {
  std::ranges::stable_sort(edits, std::greater(), &Edit::at);
  for (const Edit& edit : edits) text.replace(edit.at, edit.length, edit.text);
  return text;
}

bool is_near(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max(1.0, std::abs(b)); }

bool says(const DriveConfig& drive, const JointFit& fit) {
  const bool has_scale = drive.family == DriveFamily::kDamiao ||
                         (is_near(drive.counts_per_turn, fit.counts_per_turn) && is_near(drive.gear, fit.gear));
  return drive.is_commissioned && drive.sign == fit.sign && is_near(drive.zero_rad, fit.zero_rad) && has_scale;
}

}  // namespace

std::string with_commissioned(const std::string& text, const std::string& file_name,
                              const std::map<std::size_t, JointFit>& fits) {
  const StrictYaml yaml = StrictYaml::parse(text, file_name);
  const std::vector<YamlValue> joints = yaml.root().key("joints").list(1, kMaxJoints);
  const RobotConfig before = parse_robot(text, file_name);
  std::vector<Edit> edits;
  for (const auto& [joint, fit] : fits) {
    DriveEditor editor(text, joints.at(joint).key("drive"));
    const DriveConfig& old = before.drives.at(joint);
    editor.set("sign", std::to_string(fit.sign));
    editor.set("zero_rad", exact(fit.zero_rad));
    if (old.counts_per_turn != fit.counts_per_turn) editor.set("counts_per_turn", exact(fit.counts_per_turn));
    if (old.gear != fit.gear) editor.set("gear", exact(fit.gear));
    editor.set("commissioned", "true");
    edits.insert(edits.end(), editor.edits().begin(), editor.edits().end());
  }
  const std::string out = apply(text, edits);
  const RobotConfig after = parse_robot(out, file_name + ", as commissioned");
  for (const auto& [joint, fit] : fits)
    if (!says(after.drives.at(joint), fit))
      throw ConfigError(file_name + ": the drive of " + before.joint_names[joint] +
                        " is written in a way that cannot be changed");
  return out;
}

}  // namespace armsight::host
