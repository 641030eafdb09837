// One drive of the arm, whatever it speaks: the questions that the master asks of every family, forwarded. Angles are of
// the drive's output, before sign and zero.
#pragma once

#include <optional>
#include <variant>

#include "arm_controller/can_bus.hpp"
#include "arm_controller/mit_drive.hpp"
#include "arm_controller/node.hpp"

namespace armsight::arm {

class JointDrive {
  template <typename F>
  decltype(auto) ask(F&& f) noexcept {
    return std::visit(f, drive_);
  }
  template <typename F>
  decltype(auto) ask(F&& f) const noexcept {
    return std::visit(f, drive_);
  }

 public:
  explicit JointDrive(const NodeOptions& options) noexcept : drive_(std::in_place_type<Node>, options) {}
  explicit JointDrive(const MitOptions& options) noexcept : drive_(std::in_place_type<MitDrive>, options) {}

  void receive(const BusFrame& received, Time now) noexcept {
    if (Node* node = std::get_if<Node>(&drive_)) node->receive(received.frame, now);
    else std::get_if<MitDrive>(&drive_)->receive(received.frame, received.time);
  }
  void advance(Time now, bool is_due, PowerRequest power) noexcept {
    ask([&](auto& drive) { drive.advance(now, is_due, power); });
  }
  std::optional<CanFrame> set_target(const DriveTarget& target) noexcept {
    return ask([&](auto& drive) { return drive.set_target(target); });
  }
  std::optional<CanFrame> service_frame(Time now) noexcept {
    return ask([&](auto& drive) { return drive.service_frame(now); });
  }
  void stop(Time now) noexcept {
    ask([&](auto& drive) { drive.stop(now); });
  }
  void restart(Time now) noexcept {
    ask([&](auto& drive) { drive.restart(now); });
  }
  void recover(Time now) noexcept {
    ask([&](auto& drive) { drive.recover(now); });
  }

  std::uint8_t id() const noexcept { return ask([](auto& d) { return d.id(); }); }
  NodePhase phase() const noexcept { return ask([](auto& d) { return d.phase(); }); }
  bool is_following() const noexcept { return ask([](auto& d) { return d.is_following(); }); }
  const NodeCheck& check() const noexcept {
    return ask([](auto& d) -> const NodeCheck& { return d.check(); });
  }
  const Fault& fault() const noexcept {
    return ask([](auto& d) -> const Fault& { return d.fault(); });
  }
  bool has_feedback() const noexcept { return ask([](auto& d) { return d.has_feedback(); }); }
  bool is_fresh() const noexcept { return ask([](auto& d) { return d.is_fresh(); }); }
  double position_rad(Time at) const noexcept { return ask([at](auto& d) { return d.position_rad(at); }); }
  std::int32_t position_counts() const noexcept { return ask([](auto& d) { return d.position_counts(); }); }
  double torque_Nm() const noexcept { return ask([](auto& d) { return d.torque_Nm(); }); }

  // What one family alone knows; the other answers "no".
  bool hears_sync() const noexcept { return canopen() != nullptr; }
  bool is_resetting() const noexcept { return canopen() != nullptr && canopen()->is_resetting(); }
  bool needs_homing() const noexcept { return canopen() != nullptr && canopen()->needs_homing(); }
  bool is_homed_by_us() const noexcept { return canopen() != nullptr && canopen()->is_homed_by_us(); }
  /// Its encoder is absolute within one turn only; set_turns() adds whole ones.
  bool is_single_turn() const noexcept { return canopen() == nullptr; }
  void set_turns(int turns) noexcept {
    if (MitDrive* drive = std::get_if<MitDrive>(&drive_)) drive->set_turns(turns);
  }

  Node* canopen() noexcept { return std::get_if<Node>(&drive_); }
  const Node* canopen() const noexcept { return std::get_if<Node>(&drive_); }

 private:
  std::variant<Node, MitDrive> drive_;
};

}  // namespace armsight::arm
