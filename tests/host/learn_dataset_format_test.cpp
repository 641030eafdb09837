// The data-set folder: what is read, and how a mistake in it is told.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "host/dataset_parts.hpp"
#include "tests/host/learn_data.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::host {
namespace {

constexpr const char* kYaml = R"(dataset: small
chains:
  - name: arm
    joints:
      - {name: j1, xyz_m: [0, 0, 0.1], rpy_rad: [0, 0, 0], axis: [0, 1, 0]}
      - {name: j2, dh: {a_m: 0, alpha_rad: 0, d_m: 0, theta_rad: 0}}
camera: {on: root}
targets:
  - {name: tag, on: arm, kind: pose}
)";

class DatasetFolder : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_.path() / name) << text; }
  std::string refusal() {
    try {
      load_dataset(folder_.path());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  test::ScratchFolder folder_;
};

std::string with_plain_joints() {
  std::string yaml = kYaml;
  const std::string dh = "dh: {a_m: 0, alpha_rad: 0, d_m: 0, theta_rad: 0}";
  return yaml.replace(yaml.find(dh), dh.size(), "xyz_m: [0.2, 0, 0], rpy_rad: [0, 0, 0]");
}

TEST_F(DatasetFolder, ReadsPosesInBothForms) {
  write("dataset.yaml", with_plain_joints());
  write("samples.csv", "j1,j2,marker,x_m,y_m,z_m,qw,qx,qy,qz\n0.1,0.2,tag,1,2,3,1,0,0,0\n");
  EXPECT_EQ(load_dataset(folder_.path()).observations[0].T_C_M.p, Vector3(1, 2, 3));
  write("samples.csv",
        "j2,j1,marker,t11,t12,t13,t14,t21,t22,t23,t24,t31,t32,t33,t34\n0.2,0.1,tag,1,0,0,1,0,1,0,2,0,0,1,3\n");
  const Dataset dataset = load_dataset(folder_.path());
  EXPECT_EQ(dataset.observations[0].T_C_M.p, Vector3(1, 2, 3));
  EXPECT_EQ(dataset.observations[0].q, Eigen::Vector2d(0.1, 0.2));
}

TEST_F(DatasetFolder, TellsEveryMistakeOfTheRowsWithLineColumnAndRule) {
  write("dataset.yaml", with_plain_joints());
  write("samples.csv", "j1,j2,marker,x_m,y_m,z_m,qw,qx,qy,qz,mood\n"
                       "0.1,0.2,tag,1,2,3,1,0,0,0,good\n");
  EXPECT_NE(refusal().find("samples.csv:1:38: mood: is no known column"), std::string::npos) << refusal();
  write("samples.csv", "j1,j2,marker,x_m,y_m,z_m,qw,qx,qy,qz\n"
                       "0.1,abc,tag,1,2,3,1,0,0,0\n"
                       "0.1,0.2,bag,1,2,3,1,0,0,0\n"
                       "0.1,0.2,tag,1,2,3,1,1,0,0\n"
                       "0.1,nan,tag,1,2,3,1,0,0\n");
  const std::string text = refusal();
  EXPECT_NE(text.find("samples.csv:2:5: j2 = abc: must be a finite number"), std::string::npos) << text;
  EXPECT_NE(text.find("samples.csv:3:9: marker = bag: must be the name of a target"), std::string::npos) << text;
  EXPECT_NE(text.find("samples.csv:4:19: qw = 1: quaternion must have norm 1"), std::string::npos) << text;
  EXPECT_NE(text.find("samples.csv:5:1: 9 fields: must be 10"), std::string::npos) << text;
}

TEST_F(DatasetFolder, TellsEveryMistakeOfTheDescription) {
  write("dataset.yaml", kYaml);
  EXPECT_NE(refusal().find("dataset.yaml:"), std::string::npos) << refusal();
  std::string yaml = with_plain_joints() + "colour: red\n";
  yaml.replace(yaml.find("on: arm"), 7, "on: leg");
  write("dataset.yaml", yaml);
  const std::string text = refusal();
  EXPECT_NE(text.find("targets[0].on = leg: must be root or the name of a chain"), std::string::npos) << text;
  EXPECT_NE(text.find("dataset.yaml:10:1: colour"), std::string::npos) << text;
}

TEST_F(DatasetFolder, CornersOfSquaresAndPointsBecomePoses) {
  write("camera.yaml",
        "image_width: 640\nimage_height: 480\ncamera_name: c\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0,"
        " 500, 240, 0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: "
        "[0,0,0,0,0]}\n");
  std::string yaml = with_plain_joints();
  yaml.replace(yaml.find("camera: {on: root}"), 18, "camera: {on: root, intrinsics: camera.yaml}");
  yaml.replace(yaml.find("kind: pose"), 10, "kind: square, side_m: 0.1");
  write("dataset.yaml", yaml);
  write("samples.csv", "j1,j2,marker,u1_px,v1_px,u2_px,v2_px,u3_px,v3_px,u4_px,v4_px\n"
                       "0,0,tag,295,215,345,215,345,265,295,265\n");
  const Pose square = load_dataset(folder_.path()).observations[0].T_C_M;
  EXPECT_LT((square.p - Vector3(0, 0, 1)).norm(), 1e-3);
  yaml.replace(yaml.find("kind: square, side_m: 0.1"), 25, "kind: points");
  write("dataset.yaml", yaml);
  std::string rows = "look,j1,j2,marker,point_x_m,point_y_m,point_z_m,u_px,v_px\n";
  for (const char* point :
       {"-0.05,0.05,0,295,215", "0.05,0.05,0,345,215", "0.05,-0.05,0,345,265", "-0.05,-0.05,0,295,265"}) {
    rows += std::string("1,0,0,tag,") + point + "\n";
  }
  write("samples.csv", rows);
  const Dataset points = load_dataset(folder_.path());
  EXPECT_EQ(points.rows, 1);
  EXPECT_LT((points.observations[0].T_C_M.p - Vector3(0, 0, 1)).norm(), 1e-3);
}

TEST_F(DatasetFolder, TheVerbRunsOnLooksOfOurOwnRobotAndFindsTheOffset) {
  std::mt19937 random(3);
  const ArmModel arm = test::default_arm();
  std::filesystem::copy_file(std::filesystem::path(ARMSIGHT_SOURCE_DIR) / "arm_controller/config/ego_right_arm.yaml",
                             folder_.path() / "robot.yaml");
  const RobotConfig robot = load_robot(folder_.path() / "robot.yaml");
  write("dataset.yaml", dataset_yaml_for_robot(robot, "robot.yaml"));
  std::ostringstream rows;
  rows.precision(17);
  rows << "time_s";
  for (const auto& name : robot.joint_names) rows << "," << name;
  rows << ",marker,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (int k = 0; k < 20; ++k) {
    const JointVector q = test::random_within(arm.limits, random);
    JointVector real = q;
    real[2] += 0.05;
    const Pose T = test::default_T_C_B() * forward_kinematics(arm.chain, real);
    const Eigen::Quaterniond quat(T.R);
    rows << k;
    for (const double value : q) rows << "," << value;
    rows << ",7," << T.p.x() << "," << T.p.y() << "," << T.p.z() << "," << quat.w() << "," << quat.x() << ","
         << quat.y() << "," << quat.z() << "\n";
  }
  write("samples.csv", rows.str());
  std::ostringstream out;
  EXPECT_EQ(run_calibrate_dataset(folder_.path(), folder_.path() / "result.json", LearnCost::kLikelihood, out), 0);
  EXPECT_NE(out.str().find("offset of upper_arm_roll: +2.86"), std::string::npos) << out.str();
  EXPECT_NE(
      out.str().find("shoulder_flexion and a turn of the root seen by the camera about its axis (0.00, 0.00, 1.00)"),
      std::string::npos)
      << out.str();
  EXPECT_TRUE(std::filesystem::file_size(folder_.path() / "result.json") > 500);
}

}  // namespace
}  // namespace armsight::host
