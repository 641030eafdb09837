// The seam to the CAN bus: SocketCAN (socket_can) and the emulated bus (emulated_bus) behind one interface; several of
// them look like one (several_buses), whose frames say where they belong.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight::arm {

enum class SendResult : std::uint8_t { kSent, kQueueFull, kBusDown };

struct BusFrame {
  CanFrame frame;
  Time time;                 ///< end of the frame on the wire, own clock
  bool is_own_echo = false;  ///< our own frame, seen back after transmission: for SYNC the sampling instant
  std::uint8_t bus = 0;      ///< of several, as the robot file numbers them
};

/// What has happened since the last reading; only `lost` stays.
struct BusErrors {
  std::uint32_t error_frames = 0;
  std::uint32_t send_failures = 0;   ///< ENOBUFS or a full queue: the frame was dropped, never queued
  std::uint32_t receive_overflows = 0;
  bool error_passive = false;
  bool bus_off = false;
  bool lost = false;                 ///< interface gone, hub gone; of several: all of them
  std::uint8_t lost_buses = 0, bus_off_buses = 0;  ///< of several: a bit each
};

class CanBus {
 public:
  virtual ~CanBus() = default;
  /// Never blocks, never queues beyond the controller's own mailbox.
  virtual SendResult send(const CanFrame& frame) noexcept = 0;
  /// The same on one of several.
  virtual SendResult send_on(std::uint8_t bus, const CanFrame& frame) noexcept {
    return bus == 0 ? send(frame) : SendResult::kBusDown;
  }
  /// The next frame, in order of time; false: none (now). In lockstep exactly the frames due in this cycle.
  virtual bool receive(BusFrame& frame) noexcept = 0;
  virtual BusErrors take_errors() noexcept = 0;
  virtual const std::string& name() const = 0;  ///< "emulated:PATH", "socketcan:can0"
  /// Readable when a frame waits, for whoever has nothing else to do; -1: there is none.
  virtual int descriptor() const noexcept { return -1; }
};

}  // namespace armsight::arm
