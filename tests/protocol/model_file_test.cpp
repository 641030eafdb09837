#include "protocol/model_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "protocol/atomic_file.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight {
namespace {

const ModelFileExpectation kExpected{"ego_right_arm", 0x7d276dfa309ffa1b, 2};

ModelFile sample() {
  ModelFile file;
  file.robot = kExpected.robot;
  file.model_hash = kExpected.model_hash;
  file.model.revision = 17;
  file.model.T_C_B.R = Eigen::AngleAxisd(1.1, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  file.model.T_C_B.p = {0.1, 1.0 / 3.0, -2e-17};
  file.model.beta.resize(2);
  file.model.beta << 0.1 + 0.2, -0.05;
  StateMatrix P = StateMatrix::Identity(8, 8) * 1e-6;
  P(0, 7) = P(7, 0) = 1e-7 / 3.0;
  file.covariance = P;
  file.source = "calibration \"bench\"";
  file.date = "2025-03-01T12:00:00Z";
  file.report = {{"heldout_rms_mm", 0.7}, {"looks", 40}};
  return file;
}

std::string model_complaint(const std::string& text) {
  try {
    parse_model_file(text, "model.yaml", kExpected);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "none";
}

std::string model_with(const std::string& old_text, const std::string& new_text) {
  std::string text = to_text(sample());
  return text.replace(text.find(old_text), old_text.size(), new_text);
}

TEST(ModelFile, ComesBackAsItWas) {
  const ModelFile file = sample(), back = parse_model_file(to_text(file), "model.yaml", kExpected);
  EXPECT_EQ(back.model.revision, 17U);
  EXPECT_EQ(back.model.beta, file.model.beta);
  EXPECT_EQ(back.model.T_C_B.p, file.model.T_C_B.p);
  EXPECT_TRUE(back.model.T_C_B.R.isApprox(file.model.T_C_B.R, 1e-15));
  EXPECT_EQ(*back.covariance, *file.covariance);
  EXPECT_EQ(back.source, file.source);
  EXPECT_EQ(back.date, file.date);
  EXPECT_EQ(back.report, file.report);
}

TEST(ModelFile, MayLackCovarianceDateAndReport) {
  ModelFile file = sample();
  file.covariance.reset();
  file.date.clear();
  file.report.clear();
  const ModelFile back = parse_model_file(to_text(file), "model.yaml", kExpected);
  EXPECT_FALSE(back.covariance);
  EXPECT_TRUE(back.date.empty() && back.report.empty());
}

TEST(ModelFile, RefusesAnotherRobotAnotherDescriptionAnotherFormat) {
  EXPECT_EQ(model_complaint(model_with("\"ego_right_arm\"", "\"other\"")),
            "model.yaml:3:8: robot = other: is of another robot, expected ego_right_arm");
  EXPECT_EQ(model_complaint(model_with("0x7d276dfa309ffa1b", "0x7d276dfa309ffa1c")),
            "model.yaml:4:13: model_hash = 0x7d276dfa309ffa1c: is of another description of the arm, expected "
            "0x7d276dfa309ffa1b");
  EXPECT_EQ(model_complaint(model_with("format_version: 1", "format_version: 2")),
            "model.yaml:2:17: format_version = 2: this program reads version 1");
}

TEST(ModelFile, RefusesNumbersThatCannotBe) {
  EXPECT_TRUE(
      model_complaint(model_with("-0.050000000000000003", ".nan")).ends_with("beta_rad[1] = .nan: must be finite"));
  EXPECT_TRUE(model_complaint(model_with("-0.050000000000000003", "0.36")).find("must be between -0.349") !=
              std::string::npos);
  EXPECT_TRUE(model_complaint(model_with("0.33333333333333331", "4.9999")).ends_with("must be within 5 m"));
  ModelFile indefinite = sample();
  (*indefinite.covariance)(0, 7) = (*indefinite.covariance)(7, 0) = 2e-6;
  EXPECT_TRUE(model_complaint(to_text(indefinite)).ends_with("covariance: must be positive semidefinite"));
  EXPECT_TRUE(model_complaint(model_with(", -0.050000000000000003", "")).ends_with("has 1 entries, must have 2"));
  EXPECT_TRUE(
      model_complaint(model_with("quaternion_wxyz: [0.", "quaternion_wxyz: [0.0")).ends_with("must have length 1"));
  EXPECT_TRUE(model_complaint(model_with("3.3333333333333334e-08", "1e-7")).ends_with("covariance: must be symmetric"));
  EXPECT_TRUE(
      model_complaint(model_with("revision: 17", "revision: -1")).ends_with("must be a whole number, not negative"));
  EXPECT_TRUE(model_complaint("").ends_with("empty file"));
}

TEST(ModelFile, NeverWritesNaN) {
  ModelFile file = sample();
  file.model.beta[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(to_text(file), std::invalid_argument);
}

TEST(AtomicFile, ReplacesTheWholeFileAndLeavesNoOther) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "armsight_atomic_file";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  write_file_atomically(folder / "model.yaml", "first, and longer");
  write_file_atomically(folder / "model.yaml", "second");
  EXPECT_EQ(read_text_file(folder / "model.yaml"), "second");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_THROW(write_file_atomically(folder / "missing" / "model.yaml", "x"), std::runtime_error);
  std::filesystem::create_directory(folder / "taken");
  EXPECT_THROW(write_file_atomically(folder / "taken", "x"), std::runtime_error);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);  // no temporary is left behind
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace armsight
