// OpenCV's own photographs of markers: real paper, lens and light. The right answers stand in their PROVENANCE.md:
// ids of all pictures, corners of six markers (to 1 px). Absent photographs skip, or fail under
// ARMSIGHT_REQUIRE_DATA=1.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "host/planar_pose.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

struct Photos : ::testing::Test {
  std::filesystem::path folder;

  void SetUp() override {
    const char* named = std::getenv("ARMSIGHT_DATA");
    folder =
        (named ? std::filesystem::path(named) : std::filesystem::path(ARMSIGHT_SOURCE_DIR) / ".." / "shared" / "data") /
        "aruco-opencv-photos";
    if (std::filesystem::is_directory(folder)) return;
    const char* required = std::getenv("ARMSIGHT_REQUIRE_DATA");
    const std::string why =
        folder.string() + " is not there: set ARMSIGHT_DATA to the folder with the public data sets";
    if (required && std::string(required) == "1") FAIL() << why;
    GTEST_SKIP() << why;
  }
  cv::Mat photo(const char* name) const {
    const cv::Mat image = cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE);
    EXPECT_FALSE(image.empty()) << name;
    return image;
  }
  /// As tutorial_camera_params.yml holds it; that file names no picture size.
  static Intrinsics tutorial_camera() {
    return {640, 480, 628.158, 628.156, 324.099, 260.908, {0.0995485, -0.206384, 0.00754589, 0.00336531, 0}};
  }
};

std::vector<int> ids_of(const std::vector<MarkerDetection>& markers) {
  std::vector<int> ids;
  for (const MarkerDetection& marker : markers) ids.push_back(marker.id);
  return ids;
}
std::vector<int> first_ids(int n) {
  std::vector<int> ids;
  for (int i = 0; i < n; ++i) ids.push_back(i);
  return ids;
}

TEST_F(Photos, SixMarkersOnATableWithTheirCorners) {
  const std::map<int, Corners> golden = {{40, {cv::Point2d(359, 310), {404, 310}, {410, 350}, {362, 350}}},
                                         {98, {cv::Point2d(427, 255), {469, 256}, {477, 289}, {434, 288}}},
                                         {62, {cv::Point2d(233, 273), {190, 273}, {196, 241}, {237, 241}}},
                                         {23, {cv::Point2d(298, 185), {334, 186}, {335, 212}, {297, 211}}},
                                         {124, {cv::Point2d(425, 163), {430, 186}, {394, 186}, {390, 162}}},
                                         {203, {cv::Point2d(195, 155), {230, 155}, {227, 178}, {190, 178}}}};
  const auto markers = MarkerDetector("DICT_6X6_250").detect(photo("singlemarkersoriginal.jpg"), tutorial_camera());
  EXPECT_EQ(ids_of(markers), (std::vector<int>{23, 40, 62, 98, 124, 203}));
  double worst = 0.0;
  for (const MarkerDetection& marker : markers) {
    EXPECT_GT(marker.edge_rms_px, 0.0) << "id " << marker.id << ": no clean outline";
    for (std::size_t i = 0; i < 4; ++i)
      worst = std::max(worst, cv::norm(marker.corners_px[i] - golden.at(marker.id)[i]));
  }
  std::printf("six markers: worst corner %.2f px from the golden ones (whole pixels)\n", worst);
  EXPECT_LE(worst, 1.0);
}

/// They all lie on one table, so their normals agree: a check of the poses that needs no truth.
TEST_F(Photos, PosesOfMarkersOnOneTableAgree) {
  const auto markers = MarkerDetector("DICT_6X6_250").detect(photo("singlemarkersoriginal.jpg"), tutorial_camera());
  ASSERT_EQ(markers.size(), 6U);
  Vector3 mean = Vector3::Zero();
  std::vector<Vector3> normals;
  for (const MarkerDetection& marker : markers) {
    const auto solved = solve_planar_pose(marker.corners_px, 0.05, tutorial_camera(), 0.3);
    ASSERT_TRUE(solved) << marker.id;
    EXPECT_LT(solved->best.rms_px, 0.6) << marker.id;
    normals.push_back(solved->best.T_C_M.R.col(2));
    mean += normals.back();
  }
  mean.normalize();
  double worst = 0.0;
  for (const Vector3& normal : normals) worst = std::max(worst, std::acos(std::min(1.0, normal.dot(mean))));
  std::printf("six markers: normals agree to %.1f deg\n", worst / kDegree);
  EXPECT_LT(worst / kDegree, 6.0);
}

TEST_F(Photos, BoardOfThirtyFiveFromItsOwnDictionary) {
  StrictYaml yaml = StrictYaml::parse(
      [&] {
        std::string text = read_text_file(folder / "tutorial_dict.yml");
        return text.substr(text.find('\n') + 1);  // OpenCV's "%YAML:1.0" line
      }(),
      "tutorial_dict.yml");
  const int side = static_cast<int>(yaml.root().key("markersize").integer(3, 9));
  const int count = static_cast<int>(yaml.root().key("nmarkers").integer(1, 1000));
  std::vector<std::string> words;
  for (int i = 0; i < count; ++i) words.push_back(yaml.root().key("marker_" + std::to_string(i)).text());
  yaml.finish();
  const auto markers = MarkerDetector(side, words).detect(photo("gboriginal.png"), tutorial_camera());
  EXPECT_EQ(ids_of(markers), first_ids(35));
}

TEST_F(Photos, ChessboardMarkers) {
  const MarkerDetector detector("DICT_6X6_250");
  for (const char* name : {"choriginal.jpg", "img_00.jpg", "img_02.jpg"}) {
    const cv::Mat image = photo(name);
    Intrinsics k = tutorial_camera();
    k.width = image.cols;
    k.height = image.rows;
    const std::vector<int> ids = ids_of(detector.detect(image, k));
    std::printf("%s: %zu of 17 markers\n", name, ids.size());
    EXPECT_EQ(ids, first_ids(17)) << name;
  }
}

TEST_F(Photos, IntrinsicsFileOfTheChessboardIsRead) {
  const Intrinsics k = load_intrinsics(folder / "tutorial_camera_charuco.yml");
  EXPECT_NEAR(k.fx, 452.51072, 1e-4);
  EXPECT_NEAR(k.plumb_bob[4], 2.95425894, 1e-6);
}

}  // namespace
}  // namespace armsight::host
