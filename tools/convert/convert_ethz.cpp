// ethz-arm-sim: two streams, each t, x, y, z, qx, qy, qz, qw: the hand in the base, the camera in the target.
#include "tools/convert/text_files.hpp"

namespace armsight::tools {
namespace {

constexpr const char* kEthzYaml = R"(dataset: ethz-arm-sim
chains:
  - {name: arm, given: true}      # hand_ columns of arm.csv
camera: {on: arm}
targets:
  - {name: target, on: root, kind: pose}
noise: {sigma_m: 0.002, sigma_rad: 0.002}
max_offset_s: 0.2
)";

int convert_stream(const Path& file, const std::string& header, const std::string& before, const Path& target) {
  std::string rows = header + "\n";
  int count = 0;
  const auto lines = read_lines(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    auto fields = split(lines[i], ',');
    if (fields.size() != 8) refuse(file, i + 1, "must hold time and 7 numbers");
    for (const auto& field : fields) checked_number(field, file, i + 1);
    const std::string time = fields[0];
    fields.erase(fields.begin());
    rows += time + "," + before + join(fields) + "\n";
    ++count;
  }
  write_file(target, rows);
  return count;
}

}  // namespace

int convert_ethz(const Path& source, const Path& target) {
  convert_stream(source / "robot_arm_sim_hand.csv", "time_s,hand_x_m,hand_y_m,hand_z_m,hand_qx,hand_qy,hand_qz,hand_qw",
                 "", target / "arm.csv");
  const int looks =
      convert_stream(source / "robot_arm_sim_camera.csv",
                     "time_s,marker,camera_x_m,camera_y_m,camera_z_m,camera_qx,camera_qy,camera_qz,camera_qw",
                     "target,", target / "looks.csv");
  write_file(target / "dataset.yaml", kEthzYaml);
  return looks;
}

}  // namespace armsight::tools
