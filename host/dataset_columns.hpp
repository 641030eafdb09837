// Which column of samples.csv, arm.csv or looks.csv holds what; host/DATASET.md. Columns nobody asks for are refused.
#pragma once

#include <set>

#include "host/csv_table.hpp"
#include "host/dataset.hpp"

namespace armsight::host {

using Column = std::optional<std::size_t>;

/// Hands out columns, remembering which were asked for, so that unknown ones can be refused.
class Header {
 public:
  explicit Header(CsvTable& table) : table_(table) {}
  Column find(const std::string& name);
  /// Its absence is a violation.
  Column need(const std::string& name);
  void refuse_unknown(const std::vector<std::string>& ignored);

 private:
  CsvTable& table_;
  std::set<std::string> asked_;
};

/// A pose in columns with a prefix: x_m,y_m,z_m,qw,qx,qy,qz, or t11 … t34, the upper rows of the 4 × 4 matrix.
struct PoseColumns {
  std::vector<std::size_t> quaternion_form, matrix_form;
  bool exists() const { return !quaternion_form.empty() || !matrix_form.empty(); }
  bool is_empty(const CsvTable& table, std::size_t row) const;
};
PoseColumns find_pose(Header& header, const CsvTable& table, const std::string& prefix);
/// Records a violation where the rotation is none.
Pose read_pose(CsvTable& table, std::size_t row, const PoseColumns& columns);

/// Joint readings and the given pose: what says where the arm was.
struct ArmColumns {
  std::vector<std::size_t> joints;
  PoseColumns hand;

  ArmColumns(Header& header, const CsvTable& table, const ChainModel& model);
  Eigen::VectorXd q(CsvTable& table, std::size_t row) const;
  Pose given(CsvTable& table, std::size_t row) const;
};

/// What was seen.
struct LookColumns {
  Column marker, time, image, look, point[3], u, v;
  PoseColumns target_in_camera, second, camera_in_target;
  std::vector<std::size_t> corners;     ///< u1_px, v1_px … v4_px
  std::vector<std::size_t> covariance;  ///< cov_11, cov_12 … cov_66: upper triangle of the 6 × 6, m and rad

  LookColumns(Header& header, CsvTable& table, const Dataset& dataset);

 private:
  void find_corners(Header& header, CsvTable& table, const Dataset& dataset);
};

}  // namespace armsight::host
