// The model in force and what changes it: looks through the filter (thesis ch. 5), proposals from the host. Revisions
// only rise. Raw readings at the time of the picture come from the controller's own history (F-F4).
#pragma once

#include <optional>

#include "arm_controller/joint_history.hpp"
#include "arm_controller/messages.hpp"
#include "protocol/config.hpp"

namespace armsight::arm {

/// What the state folder held.
struct StartModel {
  LearnedModel model;
  std::optional<StateMatrix> P;
  ModelSource source = ModelSource::kNominal;
  std::optional<JointVector> last_seen_rad = std::nullopt;  ///< readings when the arm was last known
};

class Adaptation {
 public:
  Adaptation(const RobotConfig& robot, const StartModel& start);

  const LearnedModel& model() const noexcept { return model_; }
  const StateMatrix& covariance() const noexcept { return filter_.covariance(); }
  ModelSource source() const noexcept { return source_; }
  bool is_open() const noexcept { return is_open_; }

  void predict(double dt_s) noexcept { filter_.predict(dt_s); }
  /// Opens for looks: cumulative corrections count from here.
  void begin(bool keep_covariance) noexcept;
  /// The arm met something: camera or zeros may have moved. The model stays, the prior is wide again.
  void doubt() noexcept { filter_.reset(model_); }
  void close() noexcept { is_open_ = false; }
  /// kAccepted: the filter has judged it (its report says how). The event is filled in every case but kWrongState.
  AnswerEvent take(const Look& look, const JointHistory& history, FilterEvent& event) noexcept;
  AnswerEvent take(const Proposal& proposal) noexcept;

 private:
  void fill(FilterEvent& event) const noexcept;
  /// False: the look led to a model beyond reason; filter and model stand as before.
  bool fuse(const HandPoseMeasurement& z, FusionReport& report) noexcept;

  SerialChain chain_;
  Duration time_bound_;
  double max_speed_rad_s_;
  JointOffsetEkf filter_;
  LearnedModel model_, model_at_begin_;
  ModelSource source_;
  bool is_open_ = false;
};

}  // namespace armsight::arm
