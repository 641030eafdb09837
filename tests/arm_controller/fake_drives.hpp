// Scripted CiA 402 drives on an in-process bus: every answer can be bent by a test. Frames sent in a cycle act at once;
// samples of a SYNC are there in the next receive. Independent of the simulator's drives on purpose.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "arm_controller/can_bus.hpp"

namespace armsight::arm::test {

class FakeDrive {
 public:
  explicit FakeDrive(std::uint8_t node, double counts_per_turn);

  // Bends.
  bool is_silent = false;                         ///< off the bus
  bool sends_heartbeat = true;
  bool sends_feedback = true;
  bool reaches_enabled = true;                    ///< else it stays switched on
  bool heeds_target = true;                       ///< bit 12
  bool has_transition_16 = true;
  bool resets_fault = true;
  std::set<std::uint32_t> missing;                ///< objects that do not exist: index << 8 | sub
  std::map<std::uint32_t, std::uint32_t> refused_values;  ///< object → value it aborts on
  std::map<std::uint32_t, std::uint32_t> stuck;   ///< object → value that it reads as, whatever was written
  double residual_counts = 0.0;                   ///< stands so far beside its target
  double follow_per_cycle = 0.5;                  ///< share of the way it goes in a cycle
  bool ends_homing = true;                        ///< else "attained" never comes
  std::optional<double> wall_counts;              ///< cannot pass this position (fingers on an object)

  void fail(std::uint16_t emergency);
  void take(const CanFrame& frame, std::vector<CanFrame>& answers);
  void on_sync(std::vector<CanFrame>& answers);
  void boot(std::vector<CanFrame>& answers);

  std::uint32_t object(std::uint16_t index, std::uint8_t sub) const;
  std::uint16_t statusword() const;
  std::uint8_t node() const { return node_; }

  double position_counts = 0.0;
  std::int32_t target_counts = 0;
  std::uint16_t controlword = 0;
  NmtState nmt = NmtState::kPreOperational;
  DriveState state = DriveState::kSwitchOnDisabled;
  bool is_homed = false;
  std::vector<std::int32_t> profile_targets;      ///< taken with bit 4 rising
  std::vector<std::uint16_t> controlwords;        ///< each change
  std::vector<std::string> log;                   ///< "w 6060:0 8", "r 6060:0", "nmt 1"

 private:
  void take_sdo(const CanFrame& frame, std::vector<CanFrame>& answers);
  void step_state();
  void move();

  std::uint8_t node_;
  std::map<std::uint32_t, std::uint32_t> objects_;
  int syncs_ = 0;
  bool bit_4_was_up_ = false;
  std::uint16_t previous_controlword_ = 0;
};

class FakeBus final : public CanBus {
 public:
  FakeBus(std::vector<double> counts_per_turn);   ///< nodes 1 … n, the last is the hand

  SendResult send(const CanFrame& frame) noexcept override;
  bool receive(BusFrame& frame) noexcept override;
  BusErrors take_errors() noexcept override;
  const std::string& name() const override { return name_; }

  FakeDrive& drive(int node) { return drives_[static_cast<std::size_t>(node - 1)]; }
  std::vector<FakeDrive>& drives() { return drives_; }
  void inject(const CanFrame& frame) { queue(frame); }  ///< as if a node had sent it

  Time now;
  BusErrors errors;
  bool is_full = false;
  std::vector<CanFrame> sent;                     ///< since the test cleared it

 private:
  void queue(const CanFrame& frame, bool is_echo = false) { incoming_.push_back({frame, now, is_echo}); }
  std::string name_ = "fake";
  std::vector<FakeDrive> drives_;
  std::deque<BusFrame> incoming_;
};

}  // namespace armsight::arm::test
