// The shipped robot file with one thing wrong at a time: which line of complaint follows.
#include "protocol/config.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/strict_yaml.hpp"

namespace armsight {
namespace {

std::string shipped() { return read_text_file(ARMSIGHT_ROBOT_FILE); }

std::string with(const std::string& old_text, const std::string& new_text) {
  std::string text = shipped();
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return at == std::string::npos ? text : text.replace(at, old_text.size(), new_text);
}

std::string complaint(const std::string& text) {
  try {
    parse_robot(text, "robot.yaml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "none";
}

void expect_complaint(const std::string& old_text, const std::string& new_text, const std::string& end) {
  const std::string all = complaint(with(old_text, new_text));
  EXPECT_TRUE(all.starts_with("robot.yaml:") && all.ends_with(end)) << all << "\nexpected the end: " << end;
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 0) << all;
}

TEST(RobotFile, TheShippedOneLoads) {
  const RobotConfig robot = load_robot(ARMSIGHT_ROBOT_FILE);
  EXPECT_EQ(robot.robot, "ego_right_arm");
  ASSERT_EQ(robot.arm.joint_count(), 5);
  EXPECT_EQ(robot.joint_names[3], "elbow_flexion");
  EXPECT_EQ(robot.arm.limits.max_rad[3], 2.355);
  EXPECT_EQ(robot.drives[4].node, 5);
  EXPECT_EQ(robot.hand.closed_counts, 16000);
  EXPECT_TRUE(robot.arm.T_H_M.p.isApprox(Vector3(0.020, -0.030, 0)));
  EXPECT_TRUE(robot.arm.T_H_M.R.col(0).isApprox(-Vector3::UnitZ()));  // x_M = -z_H
  EXPECT_EQ(robot.controller.period_s, 0.004);
  EXPECT_EQ(robot.filter.cost_gate, 22.5);
  EXPECT_EQ(robot.postures.at("park")[3], 0.3);
}

TEST(RobotFile, NamesPlaceKeyValueAndRule) {
  EXPECT_EQ(complaint(with("period_s: 0.004", "period_s: -1")),
            "robot.yaml:48:13: controller.period_s = -1: must be between 0.001 and 0.1");
}

constexpr const char* kElbowDrive = "{node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: true}";

TEST(RobotFile, OnlyTheWordMakesAJointCommissioned) {
  EXPECT_FALSE(load_robot(ARMSIGHT_ROBOT_FILE).first_uncommissioned());
  for (const char* other : {"{node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0}",
                            "{node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: false}"})
    EXPECT_EQ(parse_robot(with(kElbowDrive, other), "robot.yaml").first_uncommissioned(), 3u) << other;
  expect_complaint(kElbowDrive, "{node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: yes}",
                   "joints[3].drive.commissioned = yes: must be true or false");
}

TEST(RobotFile, APresetNeedsADriveThatTakesIt) {
  const std::string drive = "{node: 4, counts_per_turn: 32768, sign: 1, zero_rad: 0, commissioned: true, ";
  expect_complaint(kElbowDrive, drive + "stiffness_permille: 300}",
                   "joints[3].drive.stiffness_permille = 300: needs a drive that takes it: family damiao, or "
                   "stiffness_object");
  const RobotConfig robot = parse_robot(
      with(kElbowDrive, drive + "gear: 2, stiffness_object: {index: 0x20F0, sub: 2}, stiffness_permille: 300}"), "r");
  EXPECT_EQ(robot.drives[3].stiffness_permille, 300);
  EXPECT_EQ(robot.drives[3].stiffness_object, (ObjectAddress{0x20F0, 2}));
  EXPECT_EQ(robot.drives[3].gear, 2.0);
  EXPECT_TRUE(robot.takes_stiffness(3));
  EXPECT_FALSE(robot.takes_stiffness(2));
}

TEST(RobotFile, TakesASecondBus) {
  EXPECT_EQ(load_robot(ARMSIGHT_ROBOT_FILE).bus_count(), 1);
  const RobotConfig robot = parse_robot(with("{node: 6, open", "{bus: 1, node: 6, open"), "robot.yaml");
  EXPECT_EQ(robot.bus_count(), 2);
  EXPECT_EQ(robot.hand.bus, 1);
  EXPECT_EQ(model_hash(robot), model_hash(load_robot(ARMSIGHT_ROBOT_FILE))) << "which wire it is changes no model";
  expect_complaint("{node: 6, open_counts", "{bus: 2, node: 6, open_counts",
                   "joints: no drive is on bus 1, though one is on a higher one");
}

std::string damiao(const std::string& rest) {
  return "{family: damiao, node: 4, reply_id: 20, speed_range_rad_s: 10, torque_range_Nm: 28, kp_Nm_rad: 80, "
         "sign: 1, zero_rad: 0, " + rest + "}";
}

TEST(RobotFile, TakesADamiaoDrive) {
  const std::string text = with(kElbowDrive, damiao("position_range_rad: 12.5, kd_Nms_rad: 2, fd: true"));
  const RobotConfig robot = parse_robot(text, "robot.yaml");
  EXPECT_EQ(robot.drives[3].family, DriveFamily::kDamiao);
  EXPECT_EQ(robot.drives[3].mit.reply_id, 20);
  EXPECT_EQ(robot.drives[3].mit.ranges.torque_Nm, 28.0);
  EXPECT_NEAR(robot.drives[3].counts_per_turn, 16470.7, 0.1) << "65535 codes over 25 rad";
  EXPECT_TRUE(robot.has_fd_drive(0));
  EXPECT_EQ(robot.drives[2].family, DriveFamily::kCanopen);
}

TEST(RobotFile, RefusesADamiaoDriveThatWouldMisbehave) {
  expect_complaint(kElbowDrive, damiao("position_range_rad: 12.5, kd_Nms_rad: 0"),
                   "kd_Nms_rad = 0: must be > 0: stiffness without damping swings");
  expect_complaint(kElbowDrive, damiao("position_range_rad: 8, kd_Nms_rad: 2"),
                   "position_range_rad = 8: must reach a turn beyond the limits and zero_rad: the drive wakes up "
                   "within one turn");
  expect_complaint(kElbowDrive, damiao("position_range_rad: 12.5, kd_Nms_rad: 2, mode: csv"),
                   "joints[3].drive.mode: unknown key");
  std::string taken = damiao("position_range_rad: 12.5, kd_Nms_rad: 2");
  taken.replace(taken.find("reply_id: 20"), 12, "reply_id: 6");
  expect_complaint(kElbowDrive, taken, "hand.node = 6: node id is already taken");
  taken.replace(taken.find("reply_id: 6"), 11, "reply_id: 0");
  expect_complaint(kElbowDrive, taken, "reply_id = 0: must be between 1 and 126");
}

TEST(RobotFile, ListsAllViolationsInTheOrderOfTheFile) {
  std::string text = with("period_s: 0.004", "period_s: 4");
  text.replace(text.find("robot: ego_right_arm"), 20, "robots: ego_right_arm");
  EXPECT_EQ(complaint(text),
            "robot.yaml:3:1: robot: missing\n"
            "robot.yaml:3:1: robots: unknown key\n"
            "robot.yaml:48:13: controller.period_s = 4: must be between 0.001 and 0.1");
}

TEST(RobotFile, RefusesAPeriodThatDrivesCannotBeTold) {
  expect_complaint("period_s: 0.004", "period_s: 0.00333",
                   "48:13: controller.period_s = 0.00333: must be a whole number, 1 to 255, of 1 ms or of 0.1 ms "
                   "(CANopen 0x60C2)");
  EXPECT_EQ(complaint(with("period_s: 0.004", "period_s: 0.0035")), "none");
  EXPECT_EQ(interpolation_period(0.0025)->value, 25);
  EXPECT_EQ(interpolation_period(0.0025)->exponent, -4);
  EXPECT_EQ(interpolation_period(0.1)->value, 100);
  EXPECT_EQ(interpolation_period(0.1)->exponent, -3);
}

TEST(RobotFile, RefusesLimitsThatAreBeyond32BitCounts) {
  const std::string drive = "counts_per_turn: 32768, sign: 1, zero_rad: 0";
  expect_complaint(drive, "counts_per_turn: 2147483647, sign: 1, zero_rad: -5",
                   "18:40: joints[0].drive.counts_per_turn = 2147483647: limits and zero_rad are beyond 32-bit counts");
  EXPECT_EQ(complaint(with(drive, "counts_per_turn: 2147483647, sign: 1, zero_rad: -4.5")), "none");
}

TEST(RobotFile, RefusesRepeatedKeysEverywhere) {
  expect_complaint("robot: ego_right_arm", "robot: ego_right_arm\nrobot: twice",
                   "robot.yaml:4:1: robot: repeated key, first at line 3");
  expect_complaint("d_m: 0.168,", "d_m: 0.168, d_m: 0.168,", "joints[2].dh.d_m: repeated key, first at line 22");
}

TEST(RobotFile, RefusesUnknownKeysEverywhere) {
  expect_complaint("counts_per_turn: 32768,", "counts_per_turn: 32768, turn: 1,", "joints[0].drive.turn: unknown key");
  expect_complaint("filter:", "filters: {a: 1}\nfilter:", "filters: unknown key");
}

TEST(RobotFile, SuspectsSwappedColumnsOfTheTable) {
  expect_complaint("a_m: 0, alpha_rad:  1.5707963267948966", "a_m: 1.5707963267948966, alpha_rad: 0",
                   "joints[0].dh.a_m = 1.5707963267948966: is a right angle, not a length: were a_m and alpha_rad "
                   "swapped?");
  expect_complaint("a_m: 0,", "a_m: 1.2,", "joints[0].dh.a_m = 1.2: must be between -1 and 1");
}

TEST(RobotFile, RefusesWhatIsNoFiniteNumber) {
  for (const char* bad : {".nan", ".inf", "-.inf", "inf", "nan"})
    expect_complaint("d_m: 0.185", std::string("d_m: ") + bad, "must be finite");
  for (const char* bad : {"\"0.185\"", "0.185m", "0,185", "0x1", "ten", "1_000"})
    EXPECT_NE(complaint(with("d_m: 0.185, theta", std::string("d_m: ") + bad + ", theta")), "none") << bad;
  expect_complaint("d_m: 0.185", "d_m: [0.185]", "joints[4].dh.d_m: must be a number");
}

TEST(RobotFile, RefusesImpossibleLimits) {
  expect_complaint("min_rad: 0, ", "min_rad: 3, ", "joints[3].min_rad = 3: must be below max_rad");
  expect_complaint("max_speed_rad_s: 0.5", "max_speed_rad_s: 0", "max_speed_rad_s = 0: must be > 0");
  expect_complaint("max_jerk_rad_s3: 80", "max_jerk_rad_s3: 1e9", "must be at most 100000");
}

TEST(RobotFile, RefusesNodesThatClashOrAreTheControllers) {
  expect_complaint("node: 2,", "node: 1,", "joints[1].drive.node = 1: node id is already taken");
  expect_complaint("{node: 6,", "{node: 5,", "hand.node = 5: node id is already taken");
  expect_complaint("node: 3,", "node: 127,", "joints[2].drive.node = 127: must be between 1 and 126");
  expect_complaint("sign: 1", "sign: 0", "joints[0].drive.sign = 0: must be 1 or -1");
}

TEST(RobotFile, RefusesMatricesThatAreNoRotations) {
  const std::string end = "hand_marker.rotation_rows: must be a rotation: rows orthonormal and right-handed to 1e-6";
  expect_complaint("[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]", "[[0, 0, 1], [0, 1, 0], [-1, 0, 0.00001]]", end);
  expect_complaint("[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]", "[[0, 0, 1], [0, 1, 0], [1, 0, 0]]", end);  // a mirror
  expect_complaint("[0, 1, 0], [-1, 0, 0]]", "[0, 1, 0]]", "hand_marker.rotation_rows: has 2 entries, must have 3");
}

TEST(RobotFile, NeedsDhOrFrameButNotBoth) {
  const std::string dh = "dh: {a_m: 0, alpha_rad: -1.5707963267948966, d_m: 0.185, theta_rad: 0}";
  const std::string frame = "frame: {xyz_m: [0, 0, 0.185], rpy_rad: [-1.5707963267948966, 0, 0]}";
  expect_complaint(dh, dh + ", " + frame, "joints[4]: needs exactly one of dh and frame");
  const RobotConfig by_frame = parse_robot(with(dh, frame), "robot.yaml");
  const RobotConfig by_dh = load_robot(ARMSIGHT_ROBOT_FILE);
  EXPECT_TRUE(by_frame.arm.chain.T_after[4].R.isApprox(by_dh.arm.chain.T_after[4].R, 1e-12));
  EXPECT_EQ(model_hash(by_frame), model_hash(by_dh));  // the same arm in other words
}

TEST(RobotFile, TakesOneToEightJoints) {
  std::string nine = shipped();
  const std::size_t begin = nine.find("  - {name: shoulder_flexion"), end = nine.find("  - {name: shoulder_abduction");
  const std::string joint = nine.substr(begin, end - begin);
  for (int i = 0; i < 4; ++i) nine.insert(begin, joint);
  EXPECT_EQ(complaint(nine), "robot.yaml:16:3: joints: has 9 entries, must have 1 to 8");
}

TEST(RobotFile, TakesNamedPosturesInsideTheLimits) {
  const auto home = [](const std::string& angles) {
    return with("\npostures:\n", "\npostures:\n  home: " + angles + "\n");
  };
  EXPECT_EQ(parse_robot(home("[0, -0.5, 0, 1.2, 0]"), "robot.yaml").postures.at("home")[3], 1.2);
  EXPECT_TRUE(complaint(home("[0, 0.9, 0, 1.2, 0]"))
                  .ends_with("postures.home[1] = 0.9: must be between -1.57 and 0.81"));
  EXPECT_TRUE(complaint(home("[0, 0.9]")).ends_with("has 2 entries, must have 5"));
}

TEST(RobotFile, TakesCapsulesZonesAndPairs) {
  const CollisionConfig collision = load_robot(ARMSIGHT_ROBOT_FILE).collision;
  EXPECT_EQ(collision.capsules, (std::vector<std::string>{"upper_arm", "forearm", "hand"}));
  EXPECT_EQ(collision.model.capsules[2].link, 5);
  EXPECT_EQ(collision.half_spaces, std::vector<std::string>{"floor"});
  EXPECT_EQ(collision.model.self_pairs[0], (std::array<std::uint8_t, 2>{0, 2}));
  EXPECT_EQ(load_robot(ARMSIGHT_ROBOT_FILE).contact.following_error_rad, 0.12);
}

TEST(RobotFile, ListsAllThatIsWrongWithWhatMayNotTouch) {
  std::string text = with("name: forearm, link: 5", "name: hand, link: 6");
  const auto put = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  put("normal: [0.984808, 0.030154, 0.171010]", "normal: [0.5, 0, 0]");
  put("  self:",
      "  boxes: [{name: floor, position_m: [0, 0, 0], half_size_m: [1, 0, 1], rotation_rows: "
      "[[1,0,0],[0,1,0],[0,0,1]]}]\n"
      "  self:");
  put("self: [[upper_arm, hand]]", "self: [[upper_arm, head], [hand, hand]]");
  put("time_s: 0.04}", "time_s: -1}");
  const std::string all = complaint(text);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 8) << all;
  for (const char* part : {"collision.capsules[1].link = 6: must be between 0 and 5", "name is already taken",
                           "half_spaces[0].normal", "must be of length 1", "boxes[0].half_size_m", "must be > 0",
                           "head: is the name of no capsule", "a capsule is always near itself", "contact.time_s = -1"})
    EXPECT_NE(all.find(part), std::string::npos) << part << "\n" << all;
}

TEST(RobotFile, TakesABaseThatIsNotTheFirstAxis) {
  const RobotConfig robot =
      parse_robot(shipped() + "base_to_joint1: {xyz_m: [0, 0, 0.3], rpy_rad: [0, 0, 1.5707963267948966]}\n", "r");
  EXPECT_TRUE((robot.arm.chain.T_B_0 * Vector3(1, 0, 0)).isApprox(Vector3(0, 1, 0.3), 1e-12));
}

TEST(RobotFile, RefusesUnknownMarkers) {
  expect_complaint("DICT_4X4_50", "DICT_4X5_50",
                   "dictionary = DICT_4X5_50: is no ArUco dictionary such as DICT_4X4_50");
  expect_complaint("id: 7", "id: 50", "hand_marker.id = 50: the dictionary has 50 markers, from 0");
}

TEST(RobotFile, RefusesTextThatIsNoRobotFile) {
  EXPECT_EQ(complaint(""), "robot.yaml:1:1: empty file");
  EXPECT_EQ(complaint("robot: [1, 2"), "robot.yaml:1:1: not YAML: end of sequence flow not found");
  EXPECT_TRUE(complaint(shipped() + "---\nrobot: second\n").ends_with("more than one YAML document"));
  EXPECT_TRUE(complaint("- 1\n").find("the file: must be a mapping") != std::string::npos) << complaint("- 1\n");
  EXPECT_TRUE(complaint("a: &a [*a]\n").find("nested deeper than 20 levels") != std::string::npos);
  std::string laughs = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string n = std::to_string(i), before = "*a" + std::to_string(i - 1) + " ";
    laughs += "a" + n + ": &a" + n + " [";
    for (int k = 0; k < 9; ++k) laughs += before + ", ";
    laughs += "x]\n";
  }
  EXPECT_TRUE(complaint(laughs).find("more than 100000 values") != std::string::npos);
  EXPECT_THROW(load_robot("/nonexistent/robot.yaml"), ConfigError);
}

TEST(ModelHash, ChangesWithTheArmAndNotWithTheRates) {
  const std::uint64_t shipped_hash = model_hash(load_robot(ARMSIGHT_ROBOT_FILE));
  EXPECT_EQ(shipped_hash, 0x7d276dfa309ffa1bULL) << std::hex << shipped_hash;  // stable over machines and versions
  const auto hash_with = [](const char* a, const char* b) { return model_hash(parse_robot(with(a, b), "r")); };
  EXPECT_EQ(hash_with("period_s: 0.004", "period_s: 0.002"), shipped_hash);
  EXPECT_EQ(hash_with("position_m: [0.184,", "position_m: [0.2,"), shipped_hash);
  for (const auto& [a, b] : {std::pair("d_m: 0.168", "d_m: 0.169"), {"max_rad: 0.81", "max_rad: 0.82"},
                             {"zero_rad: 0,", "zero_rad: 0.1,"}, {"sign: 1", "sign: -1"}, {"id: 7", "id: 8"},
                             {"[0.020, -0.030, 0]", "[0.021, -0.030, 0]"}, {"side_m: 0.05", "side_m: 0.051"}})
    EXPECT_NE(hash_with(a, b), shipped_hash) << a;
}

}  // namespace
}  // namespace armsight
