// The controller's side of the drives, whatever they speak (joint_drive) and on whichever bus: brings them up, keeps SYNC,
// set-points and heartbeat going, watches them and makes joint samples of what they say. Called once a cycle: receive,
// (tick), send. Never waits, no heap.
#pragma once

#include <array>
#include <optional>

#include "arm_controller/can_bus.hpp"
#include "arm_controller/joint_drive.hpp"
#include "arm_controller/joint_io.hpp"
#include "protocol/config.hpp"

namespace armsight::arm {

class DriveMaster {
 public:
  static constexpr int kMaxNodes = kMaxJoints + 1;  ///< joints and the hand

  /// last_seen: the readings when the arm was last known, to notice an encoder that lost a turn since.
  explicit DriveMaster(const RobotConfig& robot, const std::optional<JointVector>& last_seen = std::nullopt);

  /// Takes what the bus has brought since the last call. on_frame(const BusFrame&) sees every frame (the recorder).
  template <typename OnFrame>
  const JointSamples& receive(CanBus& bus, Time now, OnFrame&& on_frame) noexcept {
    BusFrame received;
    while (bus.receive(received)) {
      on_frame(received);
      take(received, now);
    }
    errors_ = bus.take_errors();
    finish_receiving(errors_, now);
    return samples_;
  }

  /// SYNC on every bus, then set-points, then at most one service frame a node and our heartbeat: sampled data always
  /// beat commands, commands beat configuration. on_frame(const BusFrame&, SendResult) sees what was sent, and what found
  /// no room.
  template <typename OnFrame>
  void send(CanBus& bus, const JointCommand& command, Time now, OnFrame&& on_frame) noexcept {
    prepare(command, now);
    for (std::size_t i = 0; i < outgoing_count_; ++i) {
      const SendResult result = bus.send_on(outgoing_[i].bus, outgoing_[i].frame);
      note_sent(i, result, now);
      on_frame(BusFrame{outgoing_[i].frame, now, false, outgoing_[i].bus}, result);
    }
  }

  const JointSamples& samples() const noexcept { return samples_; }
  int node_count() const noexcept { return node_count_; }
  const JointDrive& node(int i) const noexcept { return *nodes_[static_cast<std::size_t>(i)]; }
  const BusErrors& error_totals() const noexcept { return error_totals_; }
  const BusErrors& errors_of_cycle() const noexcept { return errors_; }
  /// Complete once every node is configured, or refused; nullopt before, and after it was taken.
  std::optional<SelfCheck> take_self_check() noexcept;

 private:
  enum class Kind : std::uint8_t { kSync, kSetPoint, kOther };
  struct Outgoing {
    CanFrame frame;
    std::uint8_t bus = 0;
    Kind kind = Kind::kOther;
  };
  struct SyncState {
    bool is_out = false;  ///< sent and not yet answered for
    Time time;            ///< the instant at which the nodes of the bus sampled
  };

  void take(const BusFrame& received, Time now) noexcept;
  void finish_receiving(const BusErrors& errors, Time now) noexcept;
  void take_errors(const BusErrors& errors) noexcept;
  void update_phase() noexcept;
  void update_joints() noexcept;
  void update_hand() noexcept;
  void note_homing() noexcept;
  bool positions_are_plausible(const JointVector& q) noexcept;
  void check_wrap(int joint, double q_rad) noexcept;
  void latch(const Fault& fault) noexcept;
  void latch_on(FaultCode code, int bus) noexcept;
  void recover(Time now) noexcept;
  void watch_encoder(int joint, double q_command_rad) noexcept;
  void prepare(const JointCommand& command, Time now) noexcept;
  void add(const CanFrame& frame, std::size_t bus, Kind kind) noexcept;
  void add_on_all(const CanFrame& frame, Kind kind) noexcept;
  Time sampling_time() const noexcept;
  std::size_t bus_of(int i) const noexcept { return bus_of_[static_cast<std::size_t>(i)]; }
  void note_sent(std::size_t i, SendResult result, Time now) noexcept;
  void settle_turns(int joint) noexcept;
  JointDrive& node_at(int i) noexcept { return *nodes_[static_cast<std::size_t>(i)]; }
  Node& hand_node() noexcept { return *node_at(joint_count_).canopen(); }

  JointLimits limits_;
  std::array<DriveConfig, kMaxJoints> drives_{};
  HandConfig hand_;
  double period_s_;
  int joint_count_ = 0, node_count_ = 0;
  std::size_t bus_count_ = 1;
  std::array<std::uint8_t, kMaxNodes> bus_of_{};
  std::array<std::optional<JointDrive>, kMaxNodes> nodes_;

  JointSamples samples_;
  std::optional<JointVector> last_seen_;
  std::array<WrapCheck, kMaxJoints> wraps_{};
  std::array<bool, kMaxJoints> was_homed_{};
  struct FrozenWatch {
    std::int32_t counts = 0;
    double q_command_rad = 0.0;          ///< when the counts last changed
    int cycles = 0;                      ///< since then
  };
  std::array<FrozenWatch, kMaxJoints> frozen_{};
  bool must_prove_positions_ = false;    ///< after an encoder's step: against last_seen_
  bool has_begun_ = false;
  bool self_check_is_due_ = true;
  PowerRequest power_ = PowerRequest::kOff;
  std::uint8_t sync_counter_ = 0;
  std::array<SyncState, kMaxBuses> syncs_{};
  std::array<bool, kMaxBuses> has_sync_{};  ///< somebody on the bus listens to SYNC and heartbeat
  Time sync_sent_{};
  Time last_fresh_{};
  std::optional<Time> own_heartbeat_;
  int failed_cycles_ = 0;
  std::optional<std::uint8_t> failed_bus_;  ///< in this cycle SYNC or set-points found no room there
  BusErrors error_totals_, errors_;

  std::array<Outgoing, 2 * kMaxNodes + 2 * kMaxBuses> outgoing_{};
  std::size_t outgoing_count_ = 0;
};

}  // namespace armsight::arm
