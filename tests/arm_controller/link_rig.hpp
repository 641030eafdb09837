// The whole program but its main: cycle on scripted drives, link over loopback TCP, files in a temporary folder; time
// is handed in. A peer is a plain stream that a test fills with envelopes.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "arm_controller/link_server.hpp"
#include "protocol/framing.hpp"
#include "protocol/transport/framed_stream.hpp"
#include "tests/arm_controller/arm_rig.hpp"
#include "tests/protocol/hand_clock.hpp"

namespace armsight::arm::test {

using net::test::HandClock;

class Peer {
 public:
  Peer(std::uint16_t port, HandClock& clock)
      : clock_(clock), stream_(net::connect_tcp("127.0.0.1:" + std::to_string(port), options(), clock,
                                                std::chrono::seconds(5))) {}

  /// Fills in version, sequence, session and time; answers the sequence number.
  std::uint64_t send(wire::Envelope envelope) {
    envelope.set_protocol_version(wire::kProtocolVersion);
    envelope.set_sequence(++sequence);
    envelope.set_session(session);
    envelope.set_sent_time_ns(to_ns(clock_.now()) + clock_offset_ns);
    stream_->send(envelope.SerializeAsString());
    return sequence;
  }
  void send_raw(std::string_view bytes) { stream_->send(bytes); }

  std::vector<wire::Envelope> take() {
    std::vector<wire::Envelope> all;
    for (const net::Received& received : stream_->receive()) {
      wire::Envelope envelope;
      EXPECT_TRUE(envelope.ParseFromString(received.payload));
      if (envelope.has_hello_reply()) session = envelope.hello_reply().session();
      all.push_back(envelope);
    }
    return all;
  }
  bool is_open() const { return stream_->is_open(); }
  void hang_up() { stream_->close("test"); }
  int descriptor() const { return stream_->descriptor(); }

  std::uint64_t sequence = 0, session = 0;
  std::int64_t clock_offset_ns = 777'000'000;

 private:
  static net::StreamOptions options() {
    net::StreamOptions o;
    o.max_incoming = wire::kMaxFromController;
    o.max_outgoing = wire::kMaxToController;
    return o;
  }
  HandClock& clock_;
  std::unique_ptr<net::FramedStream> stream_;
};

wire::Envelope hello_of(const RobotConfig& robot, wire::Role role);
/// Accepted or Refusal of that message.
bool is_answer_to(std::uint64_t sequence, const wire::Envelope& envelope);

class LinkRig {
 public:
  LinkRig();
  ~LinkRig();
  void cycle();
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  /// Cycles, with heartbeats of `peer`, until it has got a message that fits; nullopt after at_most cycles.
  std::optional<wire::Envelope> wait_for(Peer& peer, const std::function<bool(const wire::Envelope&)>& fits,
                                         int at_most = 1500);
  /// The answer, Accepted or Refusal, to a message.
  wire::Envelope answer_to(Peer& peer, std::uint64_t sequence);
  wire::RefusalReason refusal_of(Peer& peer, std::uint64_t sequence) {
    return answer_to(peer, sequence).refusal().reason();
  }
  std::unique_ptr<Peer> commander();
  std::unique_ptr<Peer> powered_commander();
  wire::Envelope hello(wire::Role role) const { return hello_of(robot, role); }

  RobotConfig robot = nominal_robot();
  std::filesystem::path folder;
  HandClock clock;
  FakeBus bus{std::vector<double>(6, 32768.0)};
  Mailboxes mailboxes;
  Tape tape;
  LoopStatistics statistics;
  std::unique_ptr<FileWriter> files;
  std::unique_ptr<LinkServer> link;
  std::unique_ptr<ControlLoop> loop;
};

}  // namespace armsight::arm::test
