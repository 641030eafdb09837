// A learnt model as a text file: the controller's model in force (model.yaml) and the host's calibration.yaml have one
// format. Text ↔ struct; who writes the file uses write_file_atomically. Metres, radians.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/config_error.hpp"
#include "shared/hand_eye.hpp"

namespace armsight {

struct ModelFile {
  std::string robot;
  std::uint64_t model_hash = 0;
  LearnedModel model;
  std::optional<StateMatrix> covariance;   ///< of [v; w; ε_β] (shared/hand_eye.hpp), rows 6 + joints
  std::string source;                      ///< "calibration", "filter", "nominal"; for people
  std::string date;                        ///< ISO 8601, given by who saves; "" where no clock may be read
  std::map<std::string, double> report;    ///< residuals and the like: heldout_rms_mm, looks …; may be empty
};

/// What the reader expects; anything else is refused.
struct ModelFileExpectation {
  std::string robot;
  std::uint64_t model_hash = 0;
  int joint_count = 0;
};

/// Numbers with 17 significant digits: reading gives the same doubles, the rotation to 1e-15. Throws
/// std::invalid_argument on NaN.
std::string to_text(const ModelFile& file);
/// Throws ConfigError with every violation; `file_name` stands in the messages. What is_plausible and
/// is_plausible_covariance (shared/hand_eye.hpp) refuse is a violation.
ModelFile parse_model_file(std::string_view text, const std::string& file_name, const ModelFileExpectation& expected);

}  // namespace armsight
