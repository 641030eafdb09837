// The controller's end of the link in the test's own hand: keeps what the host sent, answers as little as it is told.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/arm_link.pb.h"
#include "protocol/transport/framed_stream.hpp"

namespace armsight::test {

/// Steps by hand.
class ControllerStub {
 public:
  std::string address() const { return "127.0.0.1:" + std::to_string(server_.port()); }
  /// Waits up to `patience` for the host's messages and lets `on_message` answer each.
  void serve(Duration patience, const std::function<void(const wire::Envelope&)>& on_message) {
    net::wait_readable(server_.descriptors(), patience);
    for (const net::StreamServer::Event& event : server_.receive()) {
      wire::Envelope message;
      if (!event.is_closed && message.ParseFromString(event.message.payload)) on_message(message);
    }
  }
  /// To every host that is connected.
  void tell(wire::Envelope message) {
    message.set_protocol_version(wire::kProtocolVersion);
    message.set_sequence(++last_sequence_);
    for (net::FramedStream* stream : server_.streams()) stream->send(message.SerializeAsString());
  }
  void accept(const wire::Envelope& message) {
    wire::Envelope answer;
    answer.mutable_accepted()->set_accepted_sequence(message.sequence());
    tell(std::move(answer));
  }
  void tell_mode(wire::Mode mode) {
    wire::Envelope answer;
    answer.mutable_arm_state()->set_mode(mode);
    tell(std::move(answer));
  }

 private:
  std::unique_ptr<net::Clock> clock_ = net::make_monotonic_clock(std::chrono::milliseconds(4));
  net::StreamServer server_{"127.0.0.1:0",
                            net::ChannelKind::kLink,
                            {wire::FrameType::kLink, wire::kMaxToController, wire::kMaxFromController},
                            *clock_,
                            [](std::string_view) { return 0U; }};
  std::uint64_t last_sequence_ = 0;
};

/// Serves beside a verb that runs to its end in the test's thread.
class ServedStub {
 public:
  using Answer = std::function<void(ControllerStub&, const wire::Envelope&)>;
  explicit ServedStub(Answer answer)
      : answer_(std::move(answer)), thread_([this](const std::stop_token& stop) { serve(stop); }) {}

  std::string address() const { return stub_.address(); }
  /// The bodies of what came, in order; serving ends.
  std::vector<wire::Envelope::BodyCase> finish() {
    thread_.request_stop();
    thread_.join();
    return taken_;
  }

 private:
  void serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      stub_.serve(std::chrono::milliseconds(10), [&](const wire::Envelope& message) {
        taken_.push_back(message.body_case());
        answer_(stub_, message);
      });
    }
  }

  ControllerStub stub_;
  Answer answer_;
  std::vector<wire::Envelope::BodyCase> taken_;
  std::jthread thread_;
};

}  // namespace armsight::test
