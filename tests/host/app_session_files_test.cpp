// What a verb leaves: a folder that cannot be written is a bad flag at the start, a failure once the arm has moved.
#include "host/session_files.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core/mat.hpp>

#include "host/json_out.hpp"
#include "protocol/config_error.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::host {
namespace {

/// "config": exit code 2; "failure": exit code 1.
template <typename Work>
std::string thrown_by(Work work) {
  try {
    work();
  } catch (const ConfigError&) {
    return "config";
  } catch (const std::exception&) {
    return "failure";
  }
  return "nothing";
}

TEST(SessionFiles, AFolderLostOnTheWayIsAFailureNotABadFlag) {
  const TemporaryFolder folder;
  const std::filesystem::path state = folder.file("state");
  SessionFiles files(state, "move");
  std::filesystem::create_directories(state / "move.json/in the way");
  EXPECT_EQ(thrown_by([&] { files.save_result("{}"); }), "failure");
  std::filesystem::remove_all(state / "images");
  std::filesystem::create_directories(state / "images/move-01.jpg/in the way");
  EXPECT_EQ(thrown_by([&] { files.save_picture(cv::Mat(8, 8, CV_8UC1, cv::Scalar(0))); }), "failure");
  const std::filesystem::path nowhere = state / std::string(300, 'x');
  EXPECT_EQ(thrown_by([&] { SessionFiles(nowhere, "move"); }), "config");
}

TEST(Results, HoldNullWhereANumberIsNone) {
  MoveRecord record;
  record.status.set_position_error_m(std::numeric_limits<double>::quiet_NaN());
  record.status.set_orientation_error_rad(std::numeric_limits<double>::infinity());
  const std::string json = to_json(record);
  EXPECT_NE(json.find("\"position_error_m\": null"), std::string::npos) << json;
  EXPECT_NE(json.find("\"orientation_error_rad\": null"), std::string::npos) << json;
}

}  // namespace
}  // namespace armsight::host
