// What the tick says → wire messages, value by value: readings in rad (raw encoders, beta not added), rad/s, Nm, times in
// ns of the arm's clock, poses and corrections in the frames that arm_link.proto names. Nothing is judged here; the answers'
// reasons and the modes are the wire's enumerators of the same meaning.
#pragma once

#include "arm_controller/messages.hpp"
#include "arm_controller/statistics.hpp"
#include "protocol/arm_link.pb.h"

namespace armsight::arm {

void to_wire(const ArmSnapshot& state, wire::ArmState& out);
void to_wire(const GoalEvent& event, wire::GoalStatus& out);
void to_wire(const FilterEvent& event, wire::FilterReport& out);
void to_wire(const ModelEvent& event, wire::ModelUpdate& out);
void to_wire(const FaultEvent& event, wire::FaultReport& out);
/// Names of links and zones are the robot file's: the tick knows numbers only.
void to_wire(const StopEvent& event, const CollisionConfig& names, wire::StopReport& out);
/// All histograms of the cycle that have counted anything.
void add_durations(const LoopStatistics& statistics, const RobotConfig& robot, wire::ControllerStatistics& out);
wire::Mode to_wire(Mode mode);
wire::RefusalReason to_wire(Answer answer);

}  // namespace armsight::arm
