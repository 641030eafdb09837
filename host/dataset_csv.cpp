// samples.csv (or arm.csv and looks.csv) → observations. Columns and their rules: host/DATASET.md.
#include <algorithm>
#include <numeric>

#include "host/dataset_columns.hpp"
#include "host/dataset_parts.hpp"

namespace armsight::host {
namespace {

class LookReader {
 public:
  LookReader(Dataset& dataset, CsvTable& table, const LookColumns& columns)
      : dataset_(dataset), table_(table), columns_(columns) {}

  void read(std::size_t row, const Eigen::VectorXd& q, const Pose& T_0_given) {
    const auto target = target_of(row);
    if (!target) return;
    const DatasetTarget& kind = dataset_.targets[*target];
    if (kind.kind == TargetKind::kPoints && joins_last_look(row)) return add_point(row, dataset_.observations.back());
    ++dataset_.rows;
    Observation z;
    z.target = static_cast<int>(*target);
    z.q = q;
    z.T_0_given = T_0_given;
    z.sigma_px = dataset_.sigma_px;
    z.label = table_.place(row);
    const std::string missing = fill(row, kind, z);
    if (!missing.empty()) {
      dataset_.left_out.push_back({z.label, missing});
      return;
    }
    dataset_.observations.push_back(std::move(z));
    if (columns_.time) dataset_.look_time_s.push_back(table_.number(row, *columns_.time));
  }

 private:
  std::optional<std::size_t> target_of(std::size_t row) {
    const std::string& name = table_.text(row, *columns_.marker);
    for (std::size_t t = 0; t < dataset_.model.targets.size(); ++t) {
      if (dataset_.model.targets[t].name == name) return t;
    }
    table_.refuse(row, *columns_.marker, "must be the name of a target in dataset.yaml");
    return std::nullopt;
  }
  bool joins_last_look(std::size_t row) {
    const std::string& look = table_.text(row, *columns_.look);
    const bool joins = !dataset_.observations.empty() && look == last_look_;
    last_look_ = look;
    return joins;
  }
  void add_point(std::size_t row, Observation& z) {
    z.points_M.push_back(Vector3(table_.number(row, *columns_.point[0]), table_.number(row, *columns_.point[1]),
                                 table_.number(row, *columns_.point[2])));
    z.pixels.push_back({table_.number(row, *columns_.u), table_.number(row, *columns_.v)});
  }
  /// The reason why the row gives no look; empty: it does.
  std::string fill(std::size_t row, const DatasetTarget& kind, Observation& z) {
    switch (kind.kind) {
      case TargetKind::kPose: fill_pose(row, z); return {};
      case TargetKind::kPoints: add_point(row, z); return {};
      case TargetKind::kSquare:
        for (std::size_t k = 0; k < 8; k += 2) {
          z.pixels.push_back({table_.number(row, columns_.corners[k]), table_.number(row, columns_.corners[k + 1])});
        }
        break;
      case TargetKind::kChessboard:
      case TargetKind::kMarker: {
        const auto corners = corners_in_picture(dataset_, kind, table_.text(row, *columns_.image));
        if (!corners) return "the target is not found in " + table_.text(row, *columns_.image);
        z.pixels = *corners;
        break;
      }
    }
    z.points_M = points_of(kind);
    return {};
  }
  void fill_pose(std::size_t row, Observation& z) {
    z.T_C_M = columns_.target_in_camera.exists() ? read_pose(table_, row, columns_.target_in_camera)
                                                 : read_pose(table_, row, columns_.camera_in_target).inverse();
    if (columns_.second.exists() && !columns_.second.is_empty(table_, row))
      z.T_C_M_second = read_pose(table_, row, columns_.second);
    z.R_vision.diagonal() << Vector3::Constant(dataset_.sigma_m * dataset_.sigma_m),
        Vector3::Constant(dataset_.sigma_rad * dataset_.sigma_rad);
    if (columns_.covariance.size() != 21 || table_.is_empty(row, columns_.covariance[0])) return;
    std::size_t k = 0;
    for (Eigen::Index r = 0; r < 6; ++r) {
      for (Eigen::Index c = r; c < 6; ++c)
        z.R_vision(r, c) = z.R_vision(c, r) = table_.number(row, columns_.covariance[k++]);
    }
  }

  Dataset& dataset_;
  CsvTable& table_;
  const LookColumns& columns_;
  std::string last_look_;
};

/// Poses from corners, once all points of a look are in; looks that give none leave with the reason.
void finish_corner_looks(Dataset& dataset) {
  std::vector<Observation> kept;
  std::vector<double> times;
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    Observation& z = dataset.observations[i];
    if (z.has_corners() && !start_pose_from_corners(dataset.model.camera, z)) {
      dataset.left_out.push_back({z.label, "its corners give no pose in front of the camera"});
      continue;
    }
    if (!dataset.look_time_s.empty()) times.push_back(dataset.look_time_s[i]);
    kept.push_back(std::move(z));
  }
  dataset.observations = std::move(kept);
  dataset.look_time_s = std::move(times);
}

void read_samples(const DatasetColumns& ignored, Dataset& dataset) {
  CsvTable table(dataset.folder / "samples.csv");
  Header header(table);
  const ArmColumns arm(header, table, dataset.model);
  const LookColumns look(header, table, dataset);
  header.refuse_unknown(ignored.ignored);
  table.finish_header();
  LookReader reader(dataset, table, look);
  for (std::size_t row = 0; row < table.rows(); ++row) reader.read(row, arm.q(table, row), arm.given(table, row));
  table.finish();
}

/// Loggers of several threads write rows out of order and twice: what counts is the stamp.
ArmStream sorted_by_time(const ArmStream& stream) {
  std::vector<std::size_t> order(stream.time_s.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stream.time_s[a] < stream.time_s[b]; });
  ArmStream sorted;
  for (const std::size_t i : order) {
    sorted.time_s.push_back(stream.time_s[i]);
    sorted.q.push_back(stream.q[i]);
    sorted.T_0_given.push_back(stream.T_0_given[i]);
  }
  return sorted;
}

void read_streams(const DatasetColumns& ignored, Dataset& dataset) {
  CsvTable arm_table(dataset.folder / "arm.csv");
  Header arm_header(arm_table);
  const ArmColumns arm(arm_header, arm_table, dataset.model);
  const Column time = arm_header.need("time_s");
  arm_header.refuse_unknown(ignored.ignored);
  arm_table.finish_header();
  ArmStream stream;
  for (std::size_t row = 0; row < arm_table.rows(); ++row) {
    stream.time_s.push_back(arm_table.number(row, *time));
    stream.q.push_back(arm.q(arm_table, row));
    stream.T_0_given.push_back(arm.given(arm_table, row));
  }
  arm_table.finish();

  CsvTable look_table(dataset.folder / "looks.csv");
  Header look_header(look_table);
  look_header.need("time_s");
  const LookColumns look(look_header, look_table, dataset);
  look_header.refuse_unknown(ignored.ignored);
  look_table.finish_header();
  LookReader reader(dataset, look_table, look);
  const auto joints = static_cast<Eigen::Index>(dataset.model.offsets.size());
  for (std::size_t row = 0; row < look_table.rows(); ++row) reader.read(row, Eigen::VectorXd::Zero(joints), {});
  look_table.finish();
  dataset.stream = sorted_by_time(stream);
}

}  // namespace

void read_dataset_rows(const DatasetColumns& columns, Dataset& dataset) {
  const bool has_streams = std::filesystem::exists(dataset.folder / "arm.csv");
  if (has_streams && std::filesystem::exists(dataset.folder / "samples.csv")) {
    throw ConfigError(dataset.folder.string() + ": holds samples.csv and arm.csv: must be one or the other");
  }
  if (has_streams) read_streams(columns, dataset);
  else read_samples(columns, dataset);
  finish_corner_looks(dataset);
  if (dataset.observations.empty()) throw ConfigError(dataset.folder.string() + ": holds no usable look");
}

}  // namespace armsight::host
