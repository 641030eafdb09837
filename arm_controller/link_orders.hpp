// Wire commands → orders for the tick. Everything that can be judged without the tick is judged here: form, finiteness,
// limits, reach. What is refused carries its reason and a text that says what, where and which rule.
#pragma once

#include <optional>

#include "arm_controller/messages.hpp"
#include "protocol/config.hpp"
#include "protocol/convert.hpp"

namespace armsight::arm {

/// What the link knows when it judges.
struct LinkView {
  const RobotConfig& robot;
  const ArmSnapshot& state;
};

[[nodiscard]] std::optional<Refused> read_order(const wire::ModeRequest& in, ModeOrder& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::StiffnessCommand& in, const LinkView& view,
                                                StiffnessOrder& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::JointGoal& in, const LinkView& view, Goal& out);
/// Runs inverse kinematics on the model in force: milliseconds, on the link's thread.
[[nodiscard]] std::optional<Refused> read_order(const wire::PoseGoal& in, const LinkView& view, Goal& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::HandCommand& in, HandOrder& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::RecalibrationStart& in, RecalibrationOrder& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::HandPose& in, const LinkView& view, Look& out);
[[nodiscard]] std::optional<Refused> read_order(const wire::ModelProposal& in, const LinkView& view, Proposal& out);

}  // namespace armsight::arm
