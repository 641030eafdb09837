// Intrinsics files and file cameras: what is read, and what is refused with which words.
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "host/camera.hpp"
#include "protocol/config_error.hpp"
#include "tests/protocol/hand_clock.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::host {
namespace {

using namespace std::chrono_literals;

net::test::HandClock cycling_clock() {
  net::test::HandClock clock;
  clock.period = 4ms;
  return clock;
}

const char* const kRosYaml = R"(image_width: 320
image_height: 240
camera_name: test
camera_matrix: {rows: 3, cols: 3, data: [300.5, 0, 160.25, 0, 301.5, 120.75, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0.001, -0.002, 0.003]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
)";
const char* const kOpenCvYaml = R"(%YAML:1.0
---
calibration_time: "some day"
image_width: 320
image_height: 240
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 3.005e+02, 0., 160.25, 0., 301.5, 120.75, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.1, 0.02, 0.001, -0.002, 0.003 ]
)";

struct VisionFiles : ::testing::Test {
  TemporaryFolder folder;
  net::test::HandClock clock = cycling_clock();

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder.file(name)) << text;
    return folder.file(name);
  }
  std::string refusal(const std::string& text) {
    try {
      load_intrinsics(write("bad.yaml", text));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "taken";
  }
  std::string camera_refusal(const std::string& source, const std::string& intrinsics) {
    try {
      make_camera(source, intrinsics, clock);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "taken";
  }
};

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(VisionFiles, RosAndOpenCvIntrinsicsReadTheSame) {
  for (const char* text : {kRosYaml, kOpenCvYaml}) {
    const Intrinsics k = load_intrinsics(write("k.yaml", text));
    EXPECT_EQ(k.width, 320);
    EXPECT_EQ(k.height, 240);
    EXPECT_EQ(k.fx, 300.5);
    EXPECT_EQ(k.fy, 301.5);
    EXPECT_EQ(k.cx, 160.25);
    EXPECT_EQ(k.cy, 120.75);
    EXPECT_EQ(k.plumb_bob, (std::array<double, 5>{-0.1, 0.02, 0.001, -0.002, 0.003}));
  }
}

TEST_F(VisionFiles, BadIntrinsicsAreRefusedWithPlaceAndRule) {
  EXPECT_NE(refusal(with(kRosYaml, "300.5", "-1")).find("bad.yaml:4:"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, "300.5", "-1")).find("fx, fy: must be > 0"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, "300.5", ".nan")).find("must be finite"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, "300.5", "wide")).find("must be a number"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, "plumb_bob", "equidistant")).find("must be plumb_bob"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, ", 0.003]", "]").replace(0, 0, "")).find("taken"),
            std::string::npos);  // four are allowed
  EXPECT_NE(refusal(with(kRosYaml, ", -0.002, 0.003]", "]")).find("must have 4 to 5"), std::string::npos);
  EXPECT_NE(refusal(with(kRosYaml, "image_width: 320\n", "")).find("image_width: missing"), std::string::npos);
  EXPECT_NE(refusal("[1, 2]").find("must be a mapping"), std::string::npos);
  const std::string both = refusal(with(with(kRosYaml, "image_width: 320\n", ""), "300.5", "wide"));
  EXPECT_NE(both.find("image_width: missing"), std::string::npos) << both;
  EXPECT_NE(both.find("camera_matrix.data[0] = wide: must be a number"), std::string::npos) << both;
  EXPECT_NE(refusal("a: [").find("bad.yaml"), std::string::npos);
  EXPECT_THROW(load_intrinsics(folder.file("none.yaml")), ConfigError);
}

TEST_F(VisionFiles, LensIsUndoneToTheLastBit) {
  const Intrinsics k = load_intrinsics(write("k.yaml", kRosYaml));
  for (double x = -0.5; x <= 0.5; x += 0.1) {
    for (double y = -0.4; y <= 0.4; y += 0.1) {
      const Eigen::Vector2d xy(x, y);
      EXPECT_LT((undistort(k, to_pixel(k, xy)) - xy).norm(), 1e-10);
    }
  }
}

TEST_F(VisionFiles, FolderGivesItsPicturesInOrderAndEnds) {
  for (int i = 0; i < 3; ++i) {
    cv::imwrite(folder.file("p" + std::to_string(i) + ".png"),
                cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(40 * (i + 1))));
  }
  write("notes.txt", "no picture");
  const auto camera = make_camera("folder:" + std::filesystem::path(folder.file("")).parent_path().string(),
                                  write("k.yaml", kRosYaml), clock);
  EXPECT_FALSE(camera->poll());  // not asked for
  camera->request(10);
  std::vector<int> greys;
  Time last{};
  for (int i = 0; i < 100; ++i) {
    clock.wait_next_cycle();
    if (const auto frame = camera->poll()) {
      greys.push_back(frame->gray_or_bgr.at<cv::Vec3b>(5, 5)[0]);
      EXPECT_GT(frame->capture_time, last);
      last = frame->capture_time;
    }
  }
  EXPECT_EQ(greys, (std::vector<int>{40, 80, 120}));
  EXPECT_TRUE(camera->is_at_end());
}

TEST_F(VisionFiles, VideoGivesItsFrames) {
  const std::string file = folder.file("film.avi");
  cv::VideoWriter writer(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30.0, cv::Size(320, 240));
  if (!writer.isOpened()) GTEST_SKIP() << "this OpenCV writes no MJPG video";
  for (int i = 0; i < 4; ++i) writer.write(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(50 * (i + 1))));
  writer.release();
  const auto camera = make_camera("video:" + file, write("k.yaml", kRosYaml), clock);
  camera->request(100);
  int frames = 0;
  for (int i = 0; i < 100 && !camera->is_at_end(); ++i) {
    clock.wait_next_cycle();
    if (const auto frame = camera->poll()) {
      ++frames;
      EXPECT_NEAR(frame->gray_or_bgr.at<cv::Vec3b>(100, 100)[1], 50 * frames, 6);
    }
  }
  EXPECT_EQ(frames, 4);
}

TEST_F(VisionFiles, CamerasThatAreNotThereAreNamed) {
  const std::string k = write("k.yaml", kRosYaml);
  EXPECT_NE(camera_refusal("v4l2:/dev/video-none", k).find("v4l2:/dev/video-none: no such device"), std::string::npos);
  EXPECT_NE(camera_refusal("usb:1", k).find("must be sim:ADDR:PORT"), std::string::npos);
  EXPECT_NE(camera_refusal("folder", k).find("must be sim:ADDR:PORT"), std::string::npos);
  EXPECT_NE(camera_refusal("video:" + folder.file("none.avi"), k).find("is no file"), std::string::npos);
  EXPECT_NE(camera_refusal("video:" + k, k).find("is no video"), std::string::npos);
  EXPECT_NE(camera_refusal("folder:" + folder.file("none"), k).find("cannot be read"), std::string::npos);
  EXPECT_NE(camera_refusal("folder:" + std::filesystem::path(k).parent_path().string(), k).find("holds no picture"),
            std::string::npos);
  EXPECT_NE(camera_refusal("folder:x", "").find("needs an intrinsics file"), std::string::npos);
}

TEST_F(VisionFiles, PictureOfAnotherSizeThanTheIntrinsicsIsRefused) {
  cv::imwrite(folder.file("a.png"), cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(9)));
  const auto camera = make_camera("folder:" + std::filesystem::path(folder.file("a")).parent_path().string(),
                                  write("k.yaml", kRosYaml), clock);
  camera->request(1);
  EXPECT_THROW(camera->poll(), ConfigError);
}

}  // namespace
}  // namespace armsight::host
