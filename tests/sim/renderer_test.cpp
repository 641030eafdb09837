// Are the simulated pictures true? Markers where geometry puts them, noise as the noise sets say, occlusion, blur.
#include "tools/sim/renderer.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <unistd.h>

#include "host/marker.hpp"
#include "protocol/strict_yaml.hpp"
#include "tests/sim/stage_world.hpp"

namespace armsight::sim {
namespace {

using test::marker_pose;

constexpr double kSide_m = 0.05;

std::optional<host::MarkerDetection> find(const std::vector<host::MarkerDetection>& all, int id) {
  for (const auto& marker : all)
    if (marker.id == id) return marker;
  return std::nullopt;
}

struct RendererTest : ::testing::Test {
  RobotConfig robot = test::default_robot();
  host::MarkerDetector detector{"DICT_4X4_50"};

  cv::Mat picture(Renderer& renderer, const WorldView& world) { return renderer.render(std::span(&world, 1)); }
  std::optional<host::MarkerDetection> hand_marker(const cv::Mat& image, const Renderer& renderer) const {
    return find(detector.detect(image, renderer.intrinsics()), robot.hand_marker.id);
  }
};

TEST_F(RendererTest, MarkersStandWhereGeometryPutsThem) {
  Renderer renderer(test::quiet_scene(), robot.hand_marker, test::no_noise(), 1);
  std::mt19937_64 random(11);
  int seen = 0;
  double sum = 0.0, worst = 0.0;
  cv::Point2d bias(0, 0);
  Eigen::Vector2d outwards(0, 0);
  for (int i = 0; i < 60; ++i) {
    const Pose T_C_M = test::random_marker_pose(random);
    const auto marker = hand_marker(picture(renderer, test::world_with_marker(robot, T_C_M)), renderer);
    if (!marker || marker->edge_rms_px == 0.0) continue;  // wrist or elbow before it
    ++seen;
    const auto truth = *project_corners(T_C_M, kSide_m, renderer.intrinsics());
    const cv::Point2d centre = 0.25 * (truth[0] + truth[1] + truth[2] + truth[3]);
    for (std::size_t c = 0; c < 4; ++c) {
      const cv::Point2d off = marker->corners_px[c] - truth[c];
      const cv::Point2d out = truth[c] - centre;
      sum += cv::norm(off);
      worst = std::max(worst, cv::norm(off));
      bias += off;
      outwards += Eigen::Vector2d(off.dot(out) / cv::norm(out), 1.0);
    }
  }
  const double corners = 4.0 * seen;
  RecordProperty("mean_px", std::to_string(sum / corners));
  std::printf("corner error: mean %.3f px, worst %.3f px, bias (%.3f, %.3f) px, outwards %.3f px, %d of 60 poses\n",
              sum / corners, worst, bias.x / corners, bias.y / corners, outwards.x() / corners, seen);
  EXPECT_GE(seen, 30);
  EXPECT_LT(sum / corners, 0.1);
  EXPECT_LT(worst, 0.4);
  EXPECT_LT(std::abs(bias.x / corners), 0.02);
  EXPECT_LT(std::abs(bias.y / corners), 0.02);
  EXPECT_LT(std::abs(outwards.x() / corners), 0.03);  // a marker drawn too small would look too far away
}

TEST_F(RendererTest, CornerNoiseIsThatOfTheNoiseSet) {
  for (const NoiseSet set : {NoiseSet::kClean, NoiseSet::kNominal, NoiseSet::kHard}) {
    const NoiseFigures noise = noise_figures(set);
    Renderer renderer(test::default_scene(), robot.hand_marker, noise, 5);
    std::mt19937_64 random(12);
    double within = 0.0, between = 0.0, within_count = 0.0, between_count = 0.0;
    constexpr int kFrames = 6;
    for (int stop = 0; stop < 22; ++stop) {
      const Pose T_C_M = test::random_marker_pose(random);
      const WorldView world = test::world_with_marker(robot, T_C_M);
      const auto truth = *project_corners(T_C_M, kSide_m, renderer.intrinsics());
      std::vector<host::Corners> frames;
      for (int frame = 0; frame < kFrames && static_cast<int>(frames.size()) == frame; ++frame) {
        const auto marker = hand_marker(picture(renderer, world), renderer);
        if (marker && marker->edge_rms_px > 0.0) frames.push_back(marker->corners_px);
      }
      if (frames.size() != kFrames) continue;
      for (std::size_t c = 0; c < 4; ++c) {
        cv::Point2d mean(0, 0);
        for (const auto& corners : frames) mean += (1.0 / kFrames) * (corners[c] - truth[c]);
        for (const auto& corners : frames) within += (corners[c] - truth[c] - mean).dot(corners[c] - truth[c] - mean);
        within_count += 2.0 * (kFrames - 1);
        between += mean.dot(mean);
        between_count += 2.0;
      }
    }
    const double frame_px = std::sqrt(within / within_count);
    const double look_px = std::sqrt(std::max(0.0, between / between_count - frame_px * frame_px / kFrames));
    std::printf("%s: per frame %.3f px, per look %.3f px, %.0f looks\n", to_text(set), frame_px, look_px,
                between_count / 8.0);
    EXPECT_GE(between_count / 8.0, 12.0);
    EXPECT_NEAR(frame_px, noise.corner_px, 0.12 * noise.corner_px) << to_text(set);
    EXPECT_NEAR(look_px, noise.corner_bias_px, 0.04 + 0.2 * noise.corner_bias_px) << to_text(set);
  }
}

TEST_F(RendererTest, PrintTurnedAwayIsNotSeen) {
  Renderer renderer(test::default_scene(), robot.hand_marker, test::no_noise(), 1);
  const Pose front = marker_pose(0, 0, 0.3, 30 * kDegree, 0, 0);
  EXPECT_TRUE(hand_marker(picture(renderer, test::world_with_marker(robot, front)), renderer));
  const Pose back = front * Pose{so3_exp(Vector3(0, std::numbers::pi, 0)), Vector3::Zero()};
  EXPECT_FALSE(hand_marker(picture(renderer, test::world_with_marker(robot, back)), renderer));
}

TEST_F(RendererTest, TheNearerThingHidesTheFarther) {
  const Scene scene = test::default_scene();
  Renderer renderer(scene, robot.hand_marker, test::no_noise(), 1);
  WorldView world = test::world_with_marker(robot, marker_pose(-0.4, -0.2, 0.4, 30 * kDegree, 0, 0));
  world.T_B_O = test::upright_object(robot, scene.object.position_B);
  EXPECT_TRUE(find(detector.detect(picture(renderer, world), renderer.intrinsics()), scene.object.marker.id));
  const Vector3 top_C = world.T_C_B * (world.T_B_O * Vector3(0, 0, scene.object.marker_height_m));
  const Pose before = marker_pose(top_C.x() / top_C.z(), top_C.y() / top_C.z(), 0.6 * top_C.norm(), 20 * kDegree, 0, 0);
  world.T_B_H = world.T_C_B.inverse() * before * world.T_H_M.inverse();
  const auto seen = detector.detect(picture(renderer, world), renderer.intrinsics());
  EXPECT_FALSE(find(seen, scene.object.marker.id));
  EXPECT_TRUE(find(seen, robot.hand_marker.id));
}

TEST_F(RendererTest, SameSeedSamePictures) {
  std::mt19937_64 random(3);
  const std::vector<WorldView> worlds{test::world_with_marker(robot, test::random_marker_pose(random)),
                                      test::world_with_marker(robot, test::random_marker_pose(random))};
  Renderer a(test::default_scene(), robot.hand_marker, noise_figures(NoiseSet::kNominal), 7);
  Renderer b(test::default_scene(), robot.hand_marker, noise_figures(NoiseSet::kNominal), 7);
  Renderer other(test::default_scene(), robot.hand_marker, noise_figures(NoiseSet::kNominal), 8);
  for (const WorldView& world : worlds) {
    const cv::Mat image = picture(a, world);
    EXPECT_EQ(cv::norm(image, picture(b, world), cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(image, picture(other, world), cv::NORM_INF), 0.0);
  }
}

TEST_F(RendererTest, AStillArmDrawnOnceLooksAsDrawnAnew) {
  const WorldView first = test::world_with_marker(robot, marker_pose(0.1, 0, 0.3, 30 * kDegree, 1, 2));
  const WorldView elsewhere = test::world_with_marker(robot, marker_pose(-0.2, 0.1, 0.3, 30 * kDegree, 1, 2));
  Renderer kept(test::quiet_scene(), robot.hand_marker, test::no_noise(), 1);
  Renderer anew(test::quiet_scene(), robot.hand_marker, test::no_noise(), 1);
  picture(kept, first);
  picture(anew, elsewhere);
  EXPECT_EQ(cv::norm(picture(kept, first), picture(anew, first), cv::NORM_INF), 0.0);
}

TEST_F(RendererTest, MotionSmearsAboutTheMiddleOfTheExposure) {
  Renderer renderer(test::quiet_scene(), robot.hand_marker, test::no_noise(), 1);
  const Pose middle = marker_pose(0, 0, 0.3, 25 * kDegree, 0.5, 0.3);
  std::vector<WorldView> instants;
  for (int i = -2; i <= 2; ++i) {  // 0.18 m/s for 8 ms: 3.4 px
    instants.push_back(
        test::world_with_marker(robot, Pose{middle.R, middle.p + Vector3(i * 0.2 * 0.008 * 0.18, 0, 0)}));
  }
  const cv::Mat still = picture(renderer, instants[2]), moving = renderer.render(instants);
  const auto marker = hand_marker(moving, renderer);
  ASSERT_TRUE(marker);
  const auto truth = *project_corners(middle, kSide_m, renderer.intrinsics());
  for (std::size_t c = 0; c < 4; ++c) EXPECT_LT(cv::norm(marker->corners_px[c] - truth[c]), 0.25);
  cv::Mat difference;
  cv::absdiff(still, moving, difference);
  double most = 0.0;
  cv::minMaxLoc(difference, nullptr, &most);
  EXPECT_GT(most, 15.0);
}

TEST(SceneFile, TellsEveryViolationAtOnce) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("armsight-scene-" + std::to_string(::getpid()) + ".yaml");
  std::string text = read_text_file(ARMSIGHT_SOURCE_DIR "/tools/sim/scene.yaml");
  text.replace(text.find("rate_hz: 30"), 11, "rate_hz: -3");
  text.replace(text.find("exposure_s: 0.008"), 17, "exposure_z: 0.008");
  std::ofstream(file) << text;
  try {
    load_scene(file);
    ADD_FAILURE() << "taken";
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("camera.rate_hz = -3"), std::string::npos) << what;
    EXPECT_NE(what.find("exposure_z"), std::string::npos) << what;
    EXPECT_NE(what.find("exposure_s"), std::string::npos) << what;
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace armsight::sim
