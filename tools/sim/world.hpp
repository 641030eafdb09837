// The simulated robot behind its bus: plant, drives and hand as CAN nodes, and the trace of what was true.
// Driven event by event: whoever owns the time asks for the next event, advances to it and hands frames over.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "tools/sim/damiao_drive.hpp"
#include "tools/sim/drive_node.hpp"
#include "tools/sim/plant.hpp"

namespace armsight::sim {

/// One row of the trace: the joints at a SYNC.
struct TraceRow {
  Time time;
  JointVector q_true, q_reading;
};

class World {
 public:
  /// `send(i, frame, now)`: node i (joints, then the hand) puts a frame on the bus.
  using Send = std::function<void(std::size_t node, const CanFrame& frame, Time now)>;
  World(const RobotConfig& robot, const Scene& scene, Truth truth, Time start, Send send);

  void power_on(Time now);
  /// Moves plant and timers up to `time`.
  void advance_to(Time time);
  /// When a node's timer wants attention.
  Time next_time() const;
  /// A frame ended on the bus; the plant must have been advanced to `time`.
  void on_frame(std::size_t node, const CanFrame& frame, Time time);
  void inject_drift(Time now);
  /// Real pace: the machine did not run the simulator for so long.
  void excuse(Duration stall);

  std::size_t node_count() const { return nodes_.size(); }
  /// Of a CANopen node; precondition: it is one.
  const DriveNode& node(std::size_t i) const { return *dynamic_cast<const DriveNode*>(nodes_[i].get()); }
  DriveNode& node(std::size_t i) { return *dynamic_cast<DriveNode*>(nodes_[i].get()); }
  /// nullptr: joint i speaks something else.
  DamiaoDrive* damiao(std::size_t i) { return dynamic_cast<DamiaoDrive*>(nodes_[i].get()); }
  Plant& plant() { return plant_; }
  const Plant& plant() const { return plant_; }
  const RobotConfig& robot() const { return robot_; }

  const Truth& truth_before() const { return before_; }
  std::optional<Time> drift_time() const { return drift_time_; }
  const std::deque<TraceRow>& trace() const { return trace_; }
  bool trace_is_cut() const { return trace_is_cut_; }
  /// For runs longer than anybody's memory.
  void forget_trace() { trace_.clear(); }

 private:
  std::unique_ptr<BusNode> make_node(std::size_t i, const SendFrame& send);
  void open_row(Time time, std::uint8_t bus);
  void sample(std::size_t node, std::int32_t counts, Time time);
  double reading_rad(std::size_t joint, std::int32_t counts) const;

  RobotConfig robot_;
  Plant plant_;
  std::size_t opener_ = 0;  ///< node whose SYNC opens a row of the trace: the first that listens to one
  std::vector<std::unique_ptr<BusNode>> nodes_;
  Truth before_;
  std::optional<Time> drift_time_;
  std::deque<TraceRow> trace_;  ///< grows without ever copying: the bus does not wait
  bool trace_is_cut_ = false;
};

}  // namespace armsight::sim
