#include "protocol/model_file.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "protocol/config_values.hpp"

namespace armsight {

namespace {

constexpr std::int64_t kFormatVersion = 1;
constexpr double kMaxReport = 1e12;

std::string number(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("model file: a number is not finite");
  char raw[40];
  std::snprintf(raw, sizeof raw, "%.17g", value);
  return raw;
}

template <typename Values>
std::string flow_list(const Values& values) {
  std::string out = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) out += (i == 0 ? "" : ", ") + number(values[i]);
  return out + "]";
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

std::string hexadecimal(std::uint64_t value) {
  char raw[24];
  std::snprintf(raw, sizeof raw, "0x%016llx", static_cast<unsigned long long>(value));
  return raw;
}

JointVector read_beta(const YamlValue& value, int joint_count) {
  const std::vector<double> v = value.numbers(static_cast<std::size_t>(joint_count), -kMaxBeta_rad, kMaxBeta_rad);
  return Eigen::Map<const Eigen::VectorXd>(v.data(), joint_count);
}

StateMatrix read_covariance(const YamlValue& value, int size) {
  StateMatrix P = StateMatrix::Zero(size, size);
  Eigen::Index row = 0;
  const auto n = static_cast<std::size_t>(size);
  for (const YamlValue& line : value.list(n, n)) {
    const std::vector<double> v = line.numbers(n, -kMaxModelSigma * kMaxModelSigma, kMaxModelSigma * kMaxModelSigma);
    P.row(row++) = Eigen::Map<const Eigen::RowVectorXd>(v.data(), size);
  }
  if (!P.allFinite()) return P;  // its cause has been told
  if ((P - P.transpose()).cwiseAbs().maxCoeff() > 1e-9 * P.cwiseAbs().maxCoeff())
    value.refuse("must be symmetric");
  else if ((P.diagonal().array() < 0).any()) value.refuse("variances must not be negative");
  else if (!is_plausible_covariance(P)) value.refuse("must be positive semidefinite");
  return 0.5 * (P + P.transpose());
}

Pose read_quaternion_pose(const YamlValue& value) {
  Pose T;
  const YamlValue position = value.key("position_m");
  T.p = read_vector(position, kMaxCameraDistance_m);
  if (T.p.norm() > kMaxCameraDistance_m) position.refuse("must be within 5 m");
  const YamlValue wxyz = value.key("quaternion_wxyz");
  const std::vector<double> v = wxyz.numbers(4, -1.1, 1.1);
  const Eigen::Quaterniond quat(v[0], v[1], v[2], v[3]);
  if (!quat.coeffs().allFinite()) return T;
  if (std::abs(quat.norm() - 1.0) > 1e-6) wxyz.refuse("must have length 1");
  else T.R = quat.normalized().toRotationMatrix();
  return T;
}

void check_identity(const YamlValue& root, const ModelFileExpectation& expected, ModelFile& out) {
  const YamlValue version = root.key("format_version"), robot = root.key("robot"), hash = root.key("model_hash");
  if (const auto v = version.valid_integer(0, 1'000'000); v && *v != kFormatVersion)
    version.refuse("this program reads version " + std::to_string(kFormatVersion));
  out.robot = robot.text();
  out.model_hash = hash.hexadecimal();
  if (out.robot != expected.robot) robot.refuse("is of another robot, expected " + expected.robot);
  if (out.model_hash != expected.model_hash)
    hash.refuse("is of another description of the arm, expected " + hexadecimal(expected.model_hash));
}

}  // namespace

std::string to_text(const ModelFile& file) {
  const Eigen::Quaterniond quat(file.model.T_C_B.R);
  const Eigen::Vector4d wxyz(quat.w(), quat.x(), quat.y(), quat.z());
  std::string out = "# What was learnt: camera pose and joint offsets. Written by a program; SI units.\n";
  out += "format_version: " + std::to_string(kFormatVersion) + "\n";
  out += "robot: " + quoted(file.robot) + "\n";
  out += "model_hash: " + hexadecimal(file.model_hash) + "\n";
  out += "revision: " + std::to_string(file.model.revision) + "\n";
  out += "source: " + quoted(file.source) + "\n";
  if (!file.date.empty()) out += "date: " + quoted(file.date) + "\n";
  out += "T_C_B: {position_m: " + flow_list(file.model.T_C_B.p) + ", quaternion_wxyz: " + flow_list(wxyz) + "}\n";
  out += "beta_rad: " + flow_list(file.model.beta) + "\n";
  if (file.covariance) {
    out += "covariance:   # of [v, w, beta], base frame: m, rad, rad\n";
    for (const auto row : file.covariance->rowwise()) out += "  - " + flow_list(row) + "\n";
  }
  if (!file.report.empty()) out += "report:\n";
  for (const auto& [name, value] : file.report) out += "  " + quoted(name) + ": " + number(value) + "\n";
  return out;
}

ModelFile parse_model_file(std::string_view text, const std::string& file_name, const ModelFileExpectation& expected) {
  const StrictYaml yaml = StrictYaml::parse(text, file_name);
  const YamlValue root = yaml.root();
  ModelFile out;
  check_identity(root, expected, out);
  out.model.revision = root.key("revision").unsigned_integer();
  out.source = root.key("source").text();
  if (const YamlValue date = root.optional_key("date"); date.exists()) out.date = date.text();
  out.model.T_C_B = read_quaternion_pose(root.key("T_C_B"));
  out.model.beta = read_beta(root.key("beta_rad"), expected.joint_count);
  if (const YamlValue P = root.optional_key("covariance"); P.exists())
    out.covariance = read_covariance(P, kErrorBeta + expected.joint_count);
  if (const YamlValue report = root.optional_key("report"); report.exists())
    for (const auto& [name, value] : report.entries()) out.report[name] = value.number(-kMaxReport, kMaxReport);
  yaml.finish();
  return out;
}

}  // namespace armsight
