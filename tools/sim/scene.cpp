#include "tools/sim/scene.hpp"

#include "protocol/strict_yaml.hpp"

namespace armsight::sim {
namespace {

CameraOptics read_camera(const YamlValue& in) {
  CameraOptics camera;
  host::Intrinsics& k = camera.intrinsics;
  k.width = static_cast<int>(in.key("width_px").integer(64, 4096));
  k.height = static_cast<int>(in.key("height_px").integer(64, 4096));
  k.fx = k.fy = in.key("focal_px").positive(1e5);
  const std::vector<double> centre = in.key("centre_px").numbers(2, 0.0, 4096.0);
  k.cx = centre[0];
  k.cy = centre[1];
  const std::vector<double> lens = in.key("plumb_bob").numbers(5, -1.0, 1.0);
  std::copy(lens.begin(), lens.end(), k.plumb_bob.begin());
  camera.rate_hz = in.key("rate_hz").number(0.1, 200.0);
  camera.exposure_s = in.key("exposure_s").number(1e-5, 0.05);
  camera.latency_s = in.key("latency_s").number(0.0, 1.0);
  camera.latency_spread_s = in.key("latency_spread_s").number(0.0, 0.5);
  camera.defocus_px = in.key("defocus_px").number(0.0, 10.0);
  camera.read_noise_levels = in.key("read_noise_levels").number(0.0, 50.0);
  camera.shot_noise_levels = in.key("shot_noise_levels").number(0.0, 10.0);
  return camera;
}

Light read_light(const YamlValue& in) {
  Light light;
  light.exposure_gain = in.key("exposure_gain").number(0.05, 10.0);
  const std::vector<double> lamp = in.key("lamp_direction_up_forward_right").numbers(3, -1.0, 1.0);
  std::copy(lamp.begin(), lamp.end(), light.lamp_up_forward_right.begin());
  light.vignetting = in.key("vignetting").number(0.0, 0.9);
  light.gradient = in.key("gradient").number(-0.9, 0.9);
  return light;
}

Table read_table(const YamlValue& in) {
  const std::vector<double> half = in.key("half_size_m").numbers(2, 0.01, 5.0);
  const std::vector<double> shift = in.key("shift_m").numbers(2, -1.0, 1.0);
  return {half[0], half[1], in.key("thickness_m").number(0.001, 0.5), shift[0], shift[1]};
}

SceneObject read_object(const YamlValue& in) {
  SceneObject object;
  object.name = in.key("name").text();
  object.radius_m = in.key("radius_m").number(0.005, 0.5);
  object.height_m = in.key("height_m").number(0.005, 1.0);
  const std::vector<double> position = in.key("position_m").numbers(3, -2.0, 2.0);
  object.position_B = {position[0], position[1], position[2]};
  object.spread_m = in.key("spread_m").number(0.0, 0.1);
  const YamlValue marker = in.key("marker");
  object.marker.dictionary = marker.key("dictionary").text();
  object.marker.id = static_cast<int>(marker.key("id").integer(0, 1023));
  object.marker.side_m = marker.key("side_m").number(0.001, 1.0);
  object.marker_height_m = marker.key("height_m").number(0.0, 1.0);
  return object;
}

GraspTruth read_grasp(const YamlValue& in) {
  const std::vector<double> centre = in.key("centre_m").numbers(3, -0.5, 0.5);
  return {{centre[0], centre[1], centre[2]},
          in.key("tolerance_m").number(0.0, 0.1),
          in.key("tolerance_rad").number(0.0, 1.0)};
}

}  // namespace

Scene load_scene(const std::filesystem::path& file) {
  const StrictYaml yaml = StrictYaml::parse(read_text_file(file), file.string());
  const YamlValue root = yaml.root();
  Scene scene;
  scene.camera = read_camera(root.key("camera"));
  scene.light = read_light(root.key("light"));
  scene.hand_plate_side_m = root.key("hand_plate").key("side_m").number(0.01, 1.0);
  scene.table = read_table(root.key("table"));
  scene.object = read_object(root.key("object"));
  scene.grasp = read_grasp(root.key("grasp"));
  yaml.finish();
  return scene;
}

}  // namespace armsight::sim
