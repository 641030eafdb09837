// dataset.yaml → camera, targets, noise, what Learn may try; its chains are dataset_chains.cpp's. host/DATASET.md.
#include <algorithm>
#include <cmath>

#include "host/dataset_chains.hpp"
#include "host/dataset_parts.hpp"
#include "protocol/config_values.hpp"

namespace armsight::host {
namespace {

constexpr double kMaxPriorSigma_m = 100.0;  // nothing we calibrate is larger

int chain_index(const YamlValue& value, const ChainModel& model) {
  const std::string name = value.text();
  if (name == "root") return kRoot;
  for (std::size_t i = 0; i < model.chains.size(); ++i) {
    if (model.chains[i].name == name) return static_cast<int>(i);
  }
  value.refuse("must be root or the name of a chain");
  return kRoot;
}

void read_pose_unknown(const YamlValue& owner, const std::string& name, PoseUnknown& unknown) {
  unknown.name = name;
  unknown.value = optional_pose(owner, "start");
  unknown.prior = unknown.value;
  const YamlValue fixed = owner.optional_key("fixed"), prior = owner.optional_key("prior");
  if (fixed.exists() && fixed.boolean()) unknown.freedom = Freedom::kFixed;
  if (!prior.exists()) return;
  if (unknown.freedom == Freedom::kFixed) prior.refuse("makes no sense beside fixed: true");
  unknown.freedom = Freedom::kPrior;
  unknown.prior_sigma_m = prior.key("sigma_m").positive(kMaxPriorSigma_m);
  unknown.prior_sigma_rad = prior.key("sigma_rad").positive(10);
}

void read_target(const YamlValue& value, Dataset& dataset) {
  ProblemTarget target;
  DatasetTarget kind;
  const YamlValue name = value.key("name");
  target.name = name.text();
  for (const auto& other : dataset.model.targets) {
    if (other.name == target.name) name.refuse("name is already taken");
  }
  target.chain = chain_index(value.key("on"), dataset.model);
  read_pose_unknown(value, (target.chain == kRoot ? "the place of " : "the mount of ") + target.name, target.T_b_M);
  target.scale.name = target.name;
  const YamlValue kind_value = value.key("kind");
  const std::string word = kind_value.text();
  if (word == "square" || word == "marker") {
    kind.kind = word == "square" ? TargetKind::kSquare : TargetKind::kMarker;
    kind.side_m = value.key("side_m").positive(10);
  } else if (word == "points") {
    kind.kind = TargetKind::kPoints;
  } else if (word == "chessboard") {
    kind.kind = TargetKind::kChessboard;
    kind.board_columns = static_cast<int>(value.key("inner_columns").integer(2, 100));
    kind.board_rows = static_cast<int>(value.key("inner_rows").integer(2, 100));
    kind.square_m = value.key("square_m").positive(10);
  } else if (word != "pose" && !word.empty()) {
    kind_value.refuse("must be pose, square, points, chessboard or marker");
  }
  if (kind.kind == TargetKind::kMarker) {
    const YamlValue dictionary = value.key("dictionary");
    kind.dictionary = dictionary.text();
    const int most = marker_dictionary_size(kind.dictionary);
    if (most == 0) dictionary.refuse("is no ArUco dictionary");
    kind.id = static_cast<int>(value.key("id").integer(0, std::max(most - 1, 0)));
  }
  dataset.model.targets.push_back(target);
  dataset.targets.push_back(kind);
}

/// The stated scatter of a pose is where the floor's search begins; nothing of it is taken for granted.
void begin_floor_with_sigma(Dataset& dataset) {
  NoiseModel& noise = dataset.noise;
  noise.floor_position_sigma_m = std::hypot(noise.floor_position_sigma_m, dataset.sigma_m);
  noise.floor_rotation_sigma_rad = std::hypot(noise.floor_rotation_sigma_rad, dataset.sigma_rad);
  dataset.sigma_m = dataset.sigma_rad = 0.0;
}

void read_noise(const YamlValue& root, Dataset& dataset) {
  const YamlValue noise = root.optional_key("noise");
  if (!noise.exists()) return begin_floor_with_sigma(dataset);
  const YamlValue known = noise.optional_key("known");
  if (known.exists()) dataset.noise_is_known = known.boolean();
  const auto read = [&noise](const char* key, double max, double& value) {
    const YamlValue entry = noise.optional_key(key);
    if (entry.exists()) value = entry.number(0.0, max);
  };
  read("sigma_m", 1.0, dataset.sigma_m);
  read("sigma_rad", 1.0, dataset.sigma_rad);
  read("sigma_px", 100.0, dataset.sigma_px);
  read("encoder_sigma_rad", 1.0, dataset.noise.encoder_sigma_rad);
  read("floor_m", 1.0, dataset.noise.floor_position_sigma_m);
  read("floor_rad", 1.0, dataset.noise.floor_rotation_sigma_rad);
  if (dataset.sigma_m <= 0.0 && dataset.noise.floor_position_sigma_m <= 0.0)
    noise.refuse("sigma_m or floor_m must be > 0");
  if (dataset.sigma_rad <= 0.0 && dataset.noise.floor_rotation_sigma_rad <= 0.0) {
    noise.refuse("sigma_rad or floor_rad must be > 0");
  }
  if (dataset.sigma_px <= 0.0) noise.refuse("sigma_px must be > 0");
  if (!dataset.noise_is_known) begin_floor_with_sigma(dataset);
}

/// Whose zeros may be wrong, in the order of the joints; without a word all of them.
void read_offsets(const YamlValue& offsets, Dataset& dataset) {
  const auto& joints = dataset.model.offsets;
  if (!offsets.exists()) {
    for (std::size_t j = 0; j < joints.size(); ++j) dataset.offset_joints.push_back(static_cast<int>(j));
    return;
  }
  for (const auto& entry : offsets.list(0, 64)) {
    const std::string name = entry.text();
    const auto found = std::find_if(joints.begin(), joints.end(), [&](const auto& j) { return j.name == name; });
    if (found == joints.end()) entry.refuse("must be a joint of a chain");
    else dataset.offset_joints.push_back(static_cast<int>(found - joints.begin()));
  }
}

void read_learn(const YamlValue& root, Dataset& dataset) {
  const YamlValue learn = root.optional_key("learn");
  if (!learn.exists()) return read_offsets(learn, dataset);
  read_offsets(learn.optional_key("offsets"), dataset);
  const auto read = [&learn](const char* key, bool& may) {
    const YamlValue value = learn.optional_key(key);
    if (value.exists()) may = value.boolean();
  };
  read("scale", dataset.may_learn_scale);
  read("links", dataset.may_learn_links);
  read("intrinsics", dataset.may_learn_intrinsics);
  const YamlValue folds = learn.optional_key("folds");
  if (folds.exists()) dataset.folds = static_cast<int>(folds.integer(2, 100));
}

}  // namespace

DatasetColumns read_dataset_yaml(const std::filesystem::path& folder, Dataset& dataset) {
  const std::filesystem::path file = folder / "dataset.yaml";
  const StrictYaml yaml = StrictYaml::parse(read_text_file(file), file.string());
  const YamlValue root = yaml.root();
  dataset.name = root.key("dataset").text();
  for (const auto& chain : root.key("chains").list(1, 16)) read_chain(chain, folder, dataset.model);
  const YamlValue camera = root.key("camera"), on = camera.key("on");
  dataset.model.camera_chain = chain_index(on, dataset.model);
  read_pose_unknown(camera, dataset.model.camera_chain == kRoot ? "the root seen by the camera"
                                                                : "the camera mount", dataset.model.T_C_a);
  const YamlValue intrinsics = camera.optional_key("intrinsics");
  if (intrinsics.exists()) {
    try {
      dataset.model.camera = load_intrinsics(folder / intrinsics.text());
    } catch (const ConfigError& error) {
      intrinsics.refuse(error.what());
    }
  }
  for (const auto& target : root.key("targets").list(1, 64)) read_target(target, dataset);
  for (std::size_t t = 0; t < dataset.targets.size(); ++t) {
    if (dataset.targets[t].kind != TargetKind::kPose && !intrinsics.exists()) {
      camera.refuse("needs intrinsics: target " + dataset.model.targets[t].name + " is seen by its corners");
    }
  }
  read_noise(root, dataset);
  read_learn(root, dataset);
  const YamlValue max_offset = root.optional_key("max_offset_s");
  if (max_offset.exists()) dataset.max_offset_s = max_offset.number(0.0, 10.0);
  DatasetColumns columns;
  const YamlValue ignored = root.optional_key("ignore_columns");
  if (ignored.exists()) {
    for (const auto& entry : ignored.list(0, 1000)) columns.ignored.push_back(entry.text());
  }
  yaml.finish();
  return columns;
}

}  // namespace armsight::host
