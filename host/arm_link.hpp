// The host's end of the link to the arm controller: Hello, session, sequence, heartbeats with their four stamps, the
// outcome of every command, and the newest of what the arm tells. Once a cycle: receive(), then heartbeat().
// Nothing here waits; flows do, over HostIo::step. protocol/README.md has the rules of the wire.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/clock_alignment.hpp"
#include "protocol/arm_link.pb.h"
#include "protocol/transport/framed_stream.hpp"

namespace armsight::host {

/// The controller or what leads to it is gone: exit code 3.
class PeerLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What became of a command.
struct CommandOutcome {
  bool is_accepted = false;
  wire::RefusalReason reason = wire::REFUSAL_REASON_UNSPECIFIED;
  std::string text;
};

struct ArmLinkOptions {
  std::string program;
  std::uint64_t model_hash = 0;
  wire::Role role = wire::ROLE_OBSERVE;
};

class ArmLink {
 public:
  /// Sends Hello. The clock must outlive the link.
  ArmLink(std::unique_ptr<net::FramedStream> stream, net::Clock& clock, const ArmLinkOptions& options);

  /// Takes the messages that act now. Throws PeerLost when the stream is closed, holds no message or a
  /// number that is none; the link is then closed.
  void receive();
  /// Sends a heartbeat when one is due.
  void heartbeat();
  /// Sends a command; the number asks for its outcome.
  std::uint64_t send(wire::Envelope message);
  void say_bye();
  int descriptor() const { return stream_->descriptor(); }

  /// nullopt: not yet known.
  std::optional<CommandOutcome> outcome(std::uint64_t sequence) const;
  /// Refusal that came instead of the HelloReply.
  const std::optional<CommandOutcome>& hello_refusal() const { return hello_refusal_; }
  const std::optional<wire::HelloReply>& hello() const { return hello_; }

  const std::optional<wire::ArmState>& state() const { return state_; }
  const std::optional<wire::ModelUpdate>& model() const { return model_; }
  const std::optional<wire::GoalStatus>& goal_status() const { return goal_status_; }
  const std::optional<wire::FaultReport>& fault() const { return fault_; }
  /// The newest stop that needed no clearing.
  const std::optional<wire::StopReport>& stop_report() const { return stop_report_; }
  const std::optional<wire::ControllerStatistics>& statistics() const { return statistics_; }
  /// The next piece of a black box not taken yet.
  std::optional<wire::BlackBoxChunk> take_black_box_chunk() { return std::exchange(chunk_, std::nullopt); }
  /// The next filter report not taken yet.
  std::optional<wire::FilterReport> take_filter_report();
  /// Mean of the readings sampled in [from, to] of the arm's clock; nullopt where there is none.
  std::optional<std::vector<double>> mean_reading(Time arm_from, Time arm_to) const;

  const ClockAlignment& alignment() const { return alignment_; }
  /// Of the newest message: rises while the controller lives.
  std::uint64_t last_received() const { return last_received_; }

 private:
  void take(const wire::Envelope& message, Time arrival);
  void take_state(const wire::ArmState& state);
  /// Closes the stream with the reason and throws it as PeerLost.
  [[noreturn]] void end_link(const std::string& why);

  std::unique_ptr<net::FramedStream> stream_;
  net::Clock& clock_;
  std::uint64_t session_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t last_received_ = 0;
  std::uint64_t hello_sequence_ = 0;
  std::optional<Time> last_heartbeat_;
  ClockAlignment alignment_;

  std::optional<wire::HelloReply> hello_;
  std::optional<CommandOutcome> hello_refusal_;
  std::map<std::uint64_t, CommandOutcome> outcomes_;
  std::optional<wire::ArmState> state_;
  std::deque<wire::ArmState> recent_;
  std::optional<wire::ModelUpdate> model_;
  std::optional<wire::GoalStatus> goal_status_;
  std::optional<wire::FaultReport> fault_;
  std::optional<wire::StopReport> stop_report_;
  std::optional<wire::ControllerStatistics> statistics_;
  std::optional<wire::BlackBoxChunk> chunk_;
  std::deque<wire::FilterReport> filter_reports_;
};

}  // namespace armsight::host
