// The controller's cycle on scripted drives, with time handed in: bring it up, give it messages, look at what it says.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "arm_controller/black_box.hpp"
#include "arm_controller/control_loop.hpp"
#include "protocol/config.hpp"
#include "tests/arm_controller/fake_drives.hpp"

namespace armsight::arm::test {

inline constexpr const char* kRobotFile = ARMSIGHT_SOURCE_DIR "/arm_controller/config/ego_right_arm.yaml";

inline RobotConfig nominal_robot() { return load_robot(kRobotFile); }

inline StartModel nominal_start(const RobotConfig& robot) {
  return {
      {0, robot.camera_hint_T_C_B, JointVector::Zero(robot.arm.joint_count())}, std::nullopt, ModelSource::kNominal};
}

/// Five joints bent a little, and the hand.
class ArmRig {
 public:
  explicit ArmRig(const RobotConfig& robot = nominal_robot());

  void cycle();
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  bool cycle_until(const std::function<bool()>& is_true, int at_most);
  bool bring_to(Mode mode, int at_most = 2000);
  bool power_up();
  /// A commander that is there; renewed every cycle while `has_commander`.
  bool has_commander = true;
  std::uint64_t commander = 7;

  void order_mode(PowerWish wish, bool clear_fault = false);
  Goal joint_goal(std::uint64_t id, const JointVector& q_real) const;
  JointVector q_reading() const { return state.q_reading_rad; }

  template <typename E>
  const E* last() const {
    for (auto it = events.rbegin(); it != events.rend(); ++it)
      if (const E* e = std::get_if<E>(&*it)) return e;
    return nullptr;
  }
  Answer last_answer() const { return last<AnswerEvent>()->answer; }

  RobotConfig robot;
  FakeBus bus;
  Mailboxes mailboxes;
  Tape tape;
  BlackBox box;
  LoopStatistics statistics;
  std::unique_ptr<ControlLoop> loop;
  Time now = time_from_ns(1'000'000'000);
  std::uint64_t missed = 0;
  ArmSnapshot state;
  std::vector<Event> events;
};

}  // namespace armsight::arm::test
