// tools/experiments/*.yaml → Experiment, with every violation listed at once.
#include "protocol/strict_yaml.hpp"
#include "tools/report/evaluation.hpp"

namespace armsight::demo {

namespace {

JointVector commanded_pose(const YamlValue& value, const RobotConfig& robot) {
  const int joints = robot.arm.joint_count();
  JointVector q = JointVector::Zero(joints);
  const auto angles = value.numbers(static_cast<std::size_t>(joints), -6.3, 6.3);
  for (int i = 0; i < joints && i < static_cast<int>(angles.size()); ++i) {
    q(i) = angles[static_cast<std::size_t>(i)];
    if (q(i) < robot.arm.limits.min_rad(i) || q(i) > robot.arm.limits.max_rad(i)) {
      value.refuse("must lie inside the robot's limits (joint " + std::to_string(i + 1) + ")");
    }
  }
  return q;
}

}  // namespace

Experiment load_experiment(const std::filesystem::path& file, const RobotConfig& robot) {
  const StrictYaml yaml = StrictYaml::parse(read_text_file(file), file.string());
  const YamlValue root = yaml.root();
  Experiment e;
  for (const YamlValue& pose : root.key("commanded_poses_rad").list(1, 20)) {
    e.commanded_q_real.push_back(commanded_pose(pose, robot));
  }
  e.object = root.key("object").text();
  const YamlValue heldout = root.key("heldout");
  e.heldout_postures = static_cast<int>(heldout.key("postures").integer(40, 10'000));
  e.heldout_seed = heldout.key("seed").unsigned_integer();
  e.heldout_distance_rad = heldout.key("distance_rad").number(0.0, 1.0);
  e.view_x = heldout.key("view_x").positive(10.0);
  e.view_y = heldout.key("view_y").positive(10.0);
  e.min_depth_m = heldout.key("min_depth_m").positive(10.0);
  e.max_depth_m = heldout.key("max_depth_m").positive(100.0);
  e.max_tilt_rad = heldout.key("max_tilt_rad").positive(1.57);
  yaml.finish();
  return e;
}

}  // namespace armsight::demo
