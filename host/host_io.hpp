// Everything that moves while the host waits: the clock, the link to the arm, the camera. A flow is a plain loop over
// step(), the same in lockstep and at real pace; commands are sent and waited for here, so that no flow can forget.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "host/arm_link.hpp"
#include "host/camera.hpp"
#include "protocol/config.hpp"

namespace armsight::host {

/// The controller said no, or did not get there: exit code 1.
class CommandFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Ctrl-C: the arm has been told to stop where this program commanded it; the link has been left.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(bool has_stopped) : has_stopped_(has_stopped) {}
  const char* what() const noexcept override {
    return has_stopped_ ? "interrupted; the arm was told to stop" : "interrupted";
  }

 private:
  bool has_stopped_;
};

struct HostIoOptions {
  std::string arm_address;      ///< "ADDR:PORT"
  std::string camera_source;    ///< empty: none
  std::string intrinsics_file;  ///< may be empty for the simulated camera
  std::string sim_clock;        ///< path of arm_sim's clock; empty: the machine's own
  wire::Role role = wire::ROLE_OBSERVE;
  double speed_scale = 1.0;  ///< of all motions of this session, (0, 1]
};

/// A controller tells a revision when its disk has it, which takes a busy disk seconds. Whether it lives
/// is watched apart.
inline constexpr Duration kModelTimeout = std::chrono::seconds(20);

class HostIo {
 public:
  /// Connects the camera, then the arm; throws PeerLost, CameraLost, ConfigError. An observer may have an empty robot.
  HostIo(const HostIoOptions& options, const RobotConfig& robot);
  /// Says Bye, whatever happened.
  ~HostIo();

  /// One cycle: waits for it, takes what acts now, keeps the lease.
  /// Throws PeerLost, CameraLost, ClockLost, Interrupted.
  Time step();
  Time now() const { return clock_->now(); }
  /// Steps until the claim holds; false after timeout.
  bool wait_until(const std::function<bool()>& claim, Duration timeout);
  /// Sends a command and steps until it is answered; no answer within 1 s is PeerLost. A lease that ran out while the
  /// machine held this program up is taken again first: the operator's order still stands.
  CommandOutcome command(wire::Envelope message);
  /// The same, but a refusal throws CommandFailed "what: reason".
  void demand(wire::Envelope message, const std::string& what);

  /// A new link where the old one is lost; the clock and the camera stay. The session is new: no lease, no goal,
  /// nothing moves by it. Throws PeerLost where nobody answers the connection.
  void reconnect();
  /// Lets so much time go by without a link.
  void idle(Duration duration);

  /// Computes while the cycles go on. At real pace a second thread does, so that the lease lives however long it takes;
  /// in lockstep time stands still meanwhile. `work` must not touch this HostIo.
  template <typename Work>
  auto compute(Work work) {
    if (clock_->is_lockstep()) return work();
    auto result = std::async(std::launch::async, std::move(work));
    while (result.wait_for(Duration::zero()) != std::future_status::ready) step();
    return result.get();
  }

  ArmLink& arm() { return *arm_; }
  const RobotConfig& robot() const { return robot_; }
  double speed_scale() const { return options_.speed_scale; }
  bool has_camera() const { return camera_ != nullptr; }
  Camera& camera() { return *camera_; }
  /// The frame of this cycle, if one came.
  const std::optional<Frame>& frame() const { return frame_; }

 private:
  CommandOutcome ask(wire::Envelope message);
  /// A link whose other end stands still or has lost power is never closed: silence ends it. Throws PeerLost.
  void watch_silence(Time now);

  void connect();

  const RobotConfig& robot_;
  HostIoOptions options_;
  std::unique_ptr<net::Clock> clock_;  // first in, last out: the streams count on it
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<ArmLink> arm_;
  std::optional<Frame> frame_;
  bool has_had_lease_ = false;
  Time last_step_{};
  std::uint64_t heard_ = 0;       ///< the link's newest sequence number at last_step_
  Duration silence_{};
};

/// Ctrl-C and SIGTERM from now on end the next step() with Interrupted, after Stop and Bye.
void catch_interrupts();

/// Waits for the controller's answer to Hello, its state and its model; whoever looks also needs clocks that
/// agree to 2 ms.
void open_session(HostIo& io, bool needs_time);
/// "the arm stands in fault 204: …; --clear-fault clears it".
std::string fault_text(HostIo& io);
/// Takes the lease and asks for power and standstill. clear_fault is the operator's explicit word.
void take_command(HostIo& io, bool clear_fault);

}  // namespace armsight::host
