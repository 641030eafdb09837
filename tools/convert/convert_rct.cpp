// rct-two-axis-positioner: a fixed camera sees a target on two turning axes; nominal model and guesses as its README
// has them.
#include "tools/convert/text_files.hpp"

namespace armsight::tools {
namespace {

constexpr const char* kRctYaml = R"(dataset: rct-two-axis-positioner
chains:
  - name: positioner
    base: {xyz_m: [2.2, 0, 1.6], rpy_rad: [1.5707963267948966, 0, 0]}
    joints:
      - {name: joint_1, dh: {d_m: 0, theta_rad: 0, a_m: 0, alpha_rad: -1.5707963267948966}}
      - {name: joint_2, dh: {d_m: -0.475, theta_rad: -1.5707963267948966, a_m: 0, alpha_rad: 0}}
camera:
  on: root
  # The guess is the camera in the world, t (2.2, 0.7, 1.075) unturned; here its inverse, the world seen by the camera.
  start: {xyz_m: [-2.2, -0.7, -1.075], rpy_rad: [0, 0, 0]}
targets:
  - name: target
    on: positioner
    kind: pose
    start: {xyz_m: [0.17, -0.65, 0.5], quat_wxyz: [0.547419, 0.447585, -0.547419, -0.447585]}
noise: {sigma_m: 0.0005, sigma_rad: 0.001}
learn: {offsets: [joint_1, joint_2]}
)";

struct Sample {
  std::string stamp;
  std::vector<std::string> pose, joints;  // qw qx qy qz x y z; j1 j2
};

std::string after_colon(const std::string& line) { return split(line.substr(line.find(':') + 1), '\n')[0]; }

}  // namespace

int convert_rct(const Path& source, const Path& target) {
  const Path file = source / "positioner_kinematic_measurements.yaml";
  const auto lines = read_lines(file);
  const std::vector<std::string> keys{"qw", "qx", "qy", "qz", "x", "y", "z"};
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string word = split(lines[i], ':')[0];
    if (lines[i].rfind('\'', 0) == 0) {
      samples.push_back({lines[i].substr(1, lines[i].find('\'', 1) - 1), {}, {}});
      continue;
    }
    if (word.empty() || word == "camera_joints" || word == "pose" || word == "target_joints") continue;
    if (samples.empty()) refuse(file, i + 1, "must begin with a quoted time stamp");
    Sample& sample = samples.back();
    if (word.rfind("- ", 0) == 0) {
      sample.joints.push_back(checked_number(word.substr(2), file, i + 1));
    } else if (sample.pose.size() < keys.size() && word == keys[sample.pose.size()]) {
      sample.pose.push_back(checked_number(after_colon(lines[i]), file, i + 1));
    } else {
      refuse(file, i + 1, "'" + word + "' is not expected here");
    }
  }
  std::string rows = "time_s,joint_1,joint_2,marker,qw,qx,qy,qz,x_m,y_m,z_m\n";
  for (const auto& sample : samples) {
    if (sample.pose.size() != 7 || sample.joints.size() != 2)
      refuse(file, 1, sample.stamp + ": must have a pose and 2 joints");
    rows += sample.stamp + "," + join(sample.joints) + ",target," + join(sample.pose) + "\n";
  }
  write_file(target / "samples.csv", rows);
  write_file(target / "dataset.yaml", kRctYaml);
  return static_cast<int>(samples.size());
}

}  // namespace armsight::tools
