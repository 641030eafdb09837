// A simulated CANopen node (CiA 301 subset of controller.md §4): NMT, boot-up and heartbeat, heartbeat consumer, SDO
// server, one RPDO and one TPDO with the mapping procedure that drives insist on, SYNC, EMCY. What the device does
// stands in the class derived from it. Given the time, sends through a function: the same node runs on the emulated
// bus, on SocketCAN and in a test.
//
//   power-on ─► boot-up ─► pre-operational ⇄ operational ⇄ stopped        PDOs in operational only
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "protocol/sdo_segments.hpp"
#include "shared/time.hpp"
#include "tools/sim/bus_node.hpp"
#include "tools/sim/object_dictionary.hpp"

namespace armsight::sim {

class CanopenDevice : public BusNode {
 public:
  CanopenDevice(std::uint8_t node, SendFrame send);

  void power_on(Time now) override;
  /// Says nothing and hears nothing until it is powered on again.
  void power_off(Time now);
  void on_frame(const CanFrame& frame, Time now) override;
  void on_time(Time now) override;
  Time next_time() const override;
  void excuse(Duration stall) override;
  /// A fault: the object reads so from now on, whatever is written; nullopt: it does not exist. Survives a restart.
  void bend(ObjectAddress object, std::optional<std::uint32_t> value) {
    bends_[{object.index, object.sub}] = value;
  }
  /// A fault: an emergency message that nothing has caused.
  void cry(std::uint16_t code, Time now) { send_emergency(code, 0x81, now); }

  std::uint8_t node() const { return node_; }
  NmtState nmt_state() const { return state_; }

 protected:
  enum class Loss { kHeartbeat, kSetPoints, kNotOperational };

  /// Values that change by themselves; nullopt: as stored.
  virtual std::optional<std::uint32_t> live_value(ObjectAddress) { return std::nullopt; }
  /// Judges a value for an object of the device's own; 0 or an abort code.
  virtual std::uint32_t judge(ObjectAddress, std::uint32_t) const { return 0; }
  virtual bool is_receive_mappable(std::uint16_t index) const = 0;
  virtual bool is_transmit_mappable(std::uint16_t index) const = 0;
  /// Set-points of the last RPDO have been stored; they act now (with SYNC).
  virtual void act(Time now) = 0;
  virtual void lose(Loss loss, Time now) = 0;
  virtual void reset(Time now) = 0;
  virtual void on_sync(Time) {}

  void send_emergency(std::uint16_t code, std::uint8_t error_register, Time now);

  ObjectDictionary objects_;

 private:
  void add_communication_objects();
  void on_nmt(const Nmt& command, Time now);
  void restart(Time now);
  void forget_all(Time now);
  bool is_missing(ObjectAddress object) const;
  void set_state(NmtState state, Time now);
  void on_sync_frame(Time now);
  void on_heartbeat(const CanFrame& frame, Time now);
  void on_sdo(const CanFrame& frame, Time now);
  bool on_segment(const CanFrame& frame, Time now);
  void on_segmented_write(const SdoSegmentedStart& start, Time now);
  void on_segment_request(const SdoSegmentRequest& request, Time now);
  void on_written_segment(const SdoSegment& segment, Time now);
  void end_transfer(std::uint32_t code, Time now);
  void on_read(ObjectAddress object, Time now);
  void on_write(const SdoWrite& write, Time now);
  void answer_abort(ObjectAddress object, std::uint32_t code, Time now);
  std::uint32_t value_of(ObjectAddress object);
  std::uint32_t judge_communication(const SdoWrite& write) const;
  std::uint32_t judge_mapping(const SdoWrite& write) const;
  std::uint32_t judge_count(std::uint16_t mapping, std::uint32_t count) const;
  bool pdo_is_valid(std::uint16_t communication) const;
  void take_rpdo(const CanFrame& frame, Time now);
  void apply_rpdo(Time now);
  void send_tpdo(Time now);
  void send_heartbeat(Time now);
  Duration milliseconds(std::uint16_t index, std::uint8_t sub) const;

  std::uint8_t node_;
  SendFrame send_;
  bool is_on_ = true;
  std::map<std::pair<std::uint16_t, std::uint8_t>, std::optional<std::uint32_t>> bends_;  ///< index, sub
  NmtState state_ = NmtState::kBootUp;
  std::optional<CanFrame> pending_rpdo_;
  struct Transfer {
    bool is_download;
    ObjectAddress object;
    std::string bytes;         ///< received so far, or still to be sent
    std::size_t announced;     ///< 0: not told
    bool toggle;
  };
  std::optional<Transfer> transfer_;
  Time next_heartbeat_, heartbeat_deadline_, rpdo_deadline_;
};

}  // namespace armsight::sim
