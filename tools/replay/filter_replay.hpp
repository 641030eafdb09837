// A recording's looks through the filter once more: what the controller's JointOffsetEkf did with them, computed from
// the messages alone. The posture of a look is the one the controller reports for it; the random walk between looks is
// counted in whole cycles, as the controller's tick does.
#pragma once

#include <string>
#include <vector>

#include "protocol/config.hpp"
#include "shared/joint_offset_ekf.hpp"
#include "tools/replay/link_file.hpp"

namespace armsight::replay {

struct FilterStep {
  std::int64_t arm_capture_time_ns = 0;
  FusionReport report;
  LearnedModel model;                      ///< after the look
  Vector6 hand_sigma = Vector6::Zero();
  wire::FilterReport recorded;             ///< what the controller said
};

/// Throws RecordingError on a recording without a model, looks or their reports, or of an arm with other joints.
std::vector<FilterStep> replay_filter(const LinkFile& file, const RobotConfig& robot);

/// One row a look, header first; numbers with 10 significant digits.
std::string to_csv(const std::vector<FilterStep>& steps);
/// Where two such texts first differ, by more than 1e-9 of the larger or 1e-12; empty: nowhere.
std::string first_csv_difference(const std::string& golden, const std::string& now);

/// Is this message needed by replay_filter? What `ekf_replay --extract` keeps.
bool is_of_the_filter(const wire::LinkRecord& record);

}  // namespace armsight::replay
