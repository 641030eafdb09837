#include "host/dataset_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace armsight::host {
namespace {

constexpr double kExactRotation = 1e-12;  // one as good is taken to the last bit: our own looks solve to the same

}  // namespace

Column Header::find(const std::string& name) {
  const Column column = table_.column(name);
  if (column) asked_.insert(name);
  return column;
}

Column Header::need(const std::string& name) {
  const Column column = find(name);
  if (!column) table_.refuse_header(name, "column is missing");
  return column;
}

void Header::refuse_unknown(const std::vector<std::string>& ignored) {
  for (const auto& name : table_.header()) {
    if (asked_.count(name) == 0 && std::find(ignored.begin(), ignored.end(), name) == ignored.end()) {
      table_.refuse_header(name, "is no known column; name it under ignore_columns if it is not to be read");
    }
  }
}

bool PoseColumns::is_empty(const CsvTable& table, std::size_t row) const {
  return table.is_empty(row, quaternion_form.empty() ? matrix_form[0] : quaternion_form[0]);
}

PoseColumns find_pose(Header& header, const CsvTable& table, const std::string& prefix) {
  PoseColumns columns;
  if (table.column(prefix + "x_m")) {
    for (const char* name : {"x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"}) {
      const Column column = header.need(prefix + name);
      if (column) columns.quaternion_form.push_back(*column);
    }
    if (columns.quaternion_form.size() != 7) columns.quaternion_form.clear();
  } else if (table.column(prefix + "t11")) {
    for (int r = 1; r <= 3; ++r) {
      for (int c = 1; c <= 4; ++c) {
        const Column column = header.need(prefix + "t" + std::to_string(r) + std::to_string(c));
        if (column) columns.matrix_form.push_back(*column);
      }
    }
    if (columns.matrix_form.size() != 12) columns.matrix_form.clear();
  }
  return columns;
}

Pose read_pose(CsvTable& table, std::size_t row, const PoseColumns& columns) {
  Pose T;
  if (!columns.matrix_form.empty()) {
    for (std::size_t k = 0; k < 12; ++k) {
      const double value = table.number(row, columns.matrix_form[k]);
      const auto r = static_cast<Eigen::Index>(k / 4), c = static_cast<Eigen::Index>(k % 4);
      (c < 3 ? T.R(r, c) : T.p[r]) = value;
    }
    if (!is_rotation(T.R, 1e-3)) table.refuse(row, columns.matrix_form[0], "t11 … t33 must be a rotation to 1e-3");
    else if (!is_rotation(T.R, kExactRotation)) T.R = nearest_rotation(T.R);
    return T;
  }
  std::array<double, 7> v{};
  for (std::size_t k = 0; k < 7; ++k) v[k] = table.number(row, columns.quaternion_form[k]);
  const Eigen::Quaterniond quat(v[3], v[4], v[5], v[6]);
  T.p << v[0], v[1], v[2];
  if (std::abs(quat.norm() - 1.0) > 1e-3)
    table.refuse(row, columns.quaternion_form[3], "quaternion must have norm 1 to 1e-3");
  else T.R = quat.normalized().toRotationMatrix();
  return T;
}

ArmColumns::ArmColumns(Header& header, const CsvTable& table, const ChainModel& model) {
  for (const auto& joint : model.offsets) {
    const Column column = header.need(joint.name);
    if (column) joints.push_back(*column);
  }
  const bool is_given = std::any_of(model.chains.begin(), model.chains.end(), [](const auto& c) { return c.is_given; });
  if (!is_given) return;
  hand = find_pose(header, table, "hand_");
  if (!hand.exists()) header.need("hand_x_m");
}

Eigen::VectorXd ArmColumns::q(CsvTable& table, std::size_t row) const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j) q[static_cast<Eigen::Index>(j)] = table.number(row, joints[j]);
  return q;
}

Pose ArmColumns::given(CsvTable& table, std::size_t row) const {
  return hand.exists() ? read_pose(table, row, hand) : Pose{};
}

LookColumns::LookColumns(Header& header, CsvTable& table, const Dataset& dataset) {
  marker = header.need("marker");
  time = header.find("time_s");
  image = header.find("image");
  target_in_camera = find_pose(header, table, "");
  second = find_pose(header, table, "second_");
  camera_in_target = find_pose(header, table, "camera_");
  look = header.find("look");
  find_corners(header, table, dataset);
  if (!table.column("cov_11")) return;
  for (int r = 1; r <= 6; ++r) {
    for (int c = r; c <= 6; ++c) {
      if (const Column k = header.need("cov_" + std::to_string(r) + std::to_string(c))) covariance.push_back(*k);
    }
  }
}

/// The columns that the kinds of this set's targets need.
void LookColumns::find_corners(Header& header, CsvTable& table, const Dataset& dataset) {
  const auto has = [&dataset](TargetKind kind) {
    return std::any_of(dataset.targets.begin(), dataset.targets.end(),
                       [kind](const auto& t) { return t.kind == kind; });
  };
  if (has(TargetKind::kPose) && target_in_camera.exists() == camera_in_target.exists()) {
    table.refuse_header("x_m", "needs the target's pose (x_m …, t11 …) or the camera's (camera_x_m …), not both");
  }
  for (int k = 1; k <= 4 && has(TargetKind::kSquare); ++k) {
    for (const char* letter : {"u", "v"}) {
      if (const Column c = header.need(letter + std::to_string(k) + "_px")) corners.push_back(*c);
    }
  }
  if (has(TargetKind::kPoints)) {
    look = header.need("look");
    point[0] = header.need("point_x_m");
    point[1] = header.need("point_y_m");
    point[2] = header.need("point_z_m");
    u = header.need("u_px");
    v = header.need("v_px");
  }
  if (has(TargetKind::kChessboard) || has(TargetKind::kMarker)) image = header.need("image");
}

}  // namespace armsight::host
