// How to get there without coming too near to anything: straight, or over one posture between. Asks the same check as
// the controller, with the robot file's own capsules and zones. Real angles, rad. Pure.
#pragma once

#include <vector>

#include "protocol/config.hpp"

namespace armsight::host {

/// The postures to drive to one after the other, the last one q_to. Only q_to where the way is free, or where no
/// posture between helps: then the controller says why not.
std::vector<JointVector> find_route(const RobotConfig& robot, const LearnedModel& model, const JointVector& q_from,
                                    const JointVector& q_to);

}  // namespace armsight::host
