// Other people's calibration data → our data-set folders (host/DATASET.md). Rows in = rows out, numbers copied as text:
// what a row is worth is Learn's to judge. Each throws ConfigError on input that is not what its README says, and
// answers how many looks it wrote.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace armsight::tools {

using Path = std::filesystem::path;

/// TALOS: `csv` is one of the set's files (joint_names / joint_states lines); 32 joints, two wrist tags, head camera.
int convert_talos(const Path& source, const std::string& csv, const Path& target);
/// Two-axis positioner: the YAML map by time stamp.
int convert_rct(const Path& source, const Path& target);
/// UR10e: configuration_K, image-K.png, the authors' poses kept as unread columns.
int convert_ur10e(const Path& source, const Path& target);
/// CamOdoCal pairs: T1_k, T2_k as 4 × 4 matrices.
int convert_camodocal(const Path& source, const Path& target);
/// ETHZ: two stamped streams; the camera's rows are poses of the camera in the target.
int convert_ethz(const Path& source, const Path& target);

/// "talos", "rct" … by name, the default file of each; throws ConfigError for another name.
int convert(const std::string& kind, const Path& source, const Path& target);

}  // namespace armsight::tools
