#include "tools/sim/camera_server.hpp"

#include <algorithm>

#include "protocol/camera_stream.pb.h"
#include "tools/sim/random.hpp"

namespace armsight::sim {
namespace {

constexpr std::uint32_t kMaxRequest = 100'000;
constexpr std::size_t kMaxMessage = 4096;
constexpr std::uint64_t kLatencyPurpose = 0xCA3E7A;
constexpr int kInstants = 5;  // of an exposure, for motion blur

std::int64_t nanoseconds(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

net::StreamOptions stream_options() {
  net::StreamOptions options;
  options.type = wire::FrameType::kCamera;
  options.max_incoming = kMaxMessage;
  options.max_outgoing = wire::kMaxCameraFrame;
  return options;
}

std::uint32_t introduce(std::string_view first_payload) {
  wire::CameraMessage message;
  const bool is_hello =
      message.ParseFromArray(first_payload.data(), static_cast<int>(first_payload.size())) && message.has_hello();
  return is_hello ? message.hello().sim_participant() : 0;
}

}  // namespace

CameraServer::CameraServer(const std::string& address, net::Clock& clock, const Scene& scene,
                           const MarkerConfig& hand_marker, const NoiseFigures& noise, std::uint64_t seed,
                           ToOwnClock to_own_clock)
    : optics_(scene.camera),
      seed_(seed),
      to_own_clock_(std::move(to_own_clock)),
      server_(address, net::ChannelKind::kCamera, stream_options(), clock, introduce),
      renderer_(scene, hand_marker, noise, seed) {}

void CameraServer::advance(std::int64_t sim_time_ns, const WorldAt& world_at) {
  take_messages();
  begin_exposures(sim_time_ns);
  for (Exposure& exposure : exposures_) {
    if (exposure.picture.empty() && exposure.end_ns <= sim_time_ns) draw(exposure, world_at);
  }
  while (!exposures_.empty() && !exposures_.front().picture.empty() && exposures_.front().send_ns <= sim_time_ns) {
    send(exposures_.front());
    exposures_.pop_front();
  }
}

void CameraServer::take_messages() {
  for (const net::StreamServer::Event& event : server_.receive()) {
    if (event.is_closed) {
      clients_.erase(event.stream);
      for (Exposure& exposure : exposures_) std::erase(exposure.takers, event.stream);
      std::erase_if(exposures_, [](const Exposure& exposure) { return exposure.takers.empty(); });
      continue;
    }
    answer(*event.stream, clients_[event.stream], event.message.payload);
  }
}

void CameraServer::answer(net::FramedStream& stream, Client& client, const std::string& payload) {
  wire::CameraMessage message;
  if (!message.ParseFromString(payload)) {
    stream.close("camera: what came is no camera message");
    return;
  }
  if (message.has_frame_request()) client.wanted = std::min(message.frame_request().frames(), kMaxRequest);
  if (!message.has_hello()) return;
  client.participant = message.hello().sim_participant();
  wire::CameraMessage reply;
  wire::Intrinsics& out = *reply.mutable_hello()->mutable_intrinsics();
  const host::Intrinsics& k = optics_.intrinsics;
  out.set_width_px(static_cast<std::uint32_t>(k.width));
  out.set_height_px(static_cast<std::uint32_t>(k.height));
  out.set_fx_px(k.fx);
  out.set_fy_px(k.fy);
  out.set_cx_px(k.cx);
  out.set_cy_px(k.cy);
  for (const double number : k.plumb_bob) out.add_distortion(number);
  reply.mutable_hello()->set_rate_hz(optics_.rate_hz);
  stream.send(reply.SerializeAsString());
}

/// Exposure n begins at n / rate. Requests that came up to now count for exposures that begin up to now.
void CameraServer::begin_exposures(std::int64_t now_ns) {
  const std::int64_t period_ns = nanoseconds(1.0 / optics_.rate_hz), exposure_ns = nanoseconds(optics_.exposure_s);
  const std::uint64_t due = now_ns < 0 ? 0 : static_cast<std::uint64_t>(now_ns / period_ns) + 1;
  const bool is_wanted =
      std::any_of(clients_.begin(), clients_.end(), [](const auto& c) { return c.second.wanted > 0; });
  if (!is_wanted) next_number_ = std::max(next_number_, due);
  for (; next_number_ < due; ++next_number_) {
    Exposure exposure;
    for (auto& [stream, client] : clients_) {
      if (client.wanted == 0 || !stream->is_open()) continue;
      --client.wanted;
      exposure.takers.push_back(stream);
    }
    if (exposure.takers.empty()) continue;
    exposure.number = next_number_;
    const std::int64_t begin_ns = static_cast<std::int64_t>(next_number_) * period_ns;
    exposure.middle_ns = begin_ns + exposure_ns / 2;
    exposure.end_ns = begin_ns + exposure_ns;
    Random random(seed_, kLatencyPurpose, next_number_);
    const double latency_s = optics_.latency_s + random.uniform(-1.0, 1.0) * optics_.latency_spread_s;
    exposure.send_ns = std::max(exposure.end_ns, exposure.middle_ns + nanoseconds(latency_s));
    exposures_.push_back(std::move(exposure));
  }
}

void CameraServer::draw(Exposure& exposure, const WorldAt& world_at) {
  std::array<WorldView, kInstants> instants;
  for (int i = 0; i < kInstants; ++i) {
    const double part = (i + 0.5) / kInstants - 0.5;  // of the exposure, about its middle
    instants[static_cast<std::size_t>(i)] =
        world_at(static_cast<double>(exposure.middle_ns) * 1e-9 + part * optics_.exposure_s);
  }
  exposure.picture = renderer_.render(instants);
  ++rendered_;
}

void CameraServer::send(const Exposure& exposure) {
  for (net::FramedStream* stream : exposure.takers) {
    wire::CameraMessage message;
    wire::Frame& frame = *message.mutable_frame();
    frame.set_capture_time_ns(to_own_clock_(clients_.at(stream).participant, exposure.middle_ns));
    frame.set_width_px(static_cast<std::uint32_t>(exposure.picture.cols));
    frame.set_height_px(static_cast<std::uint32_t>(exposure.picture.rows));
    frame.set_format(wire::PIXEL_FORMAT_GRAY8);
    frame.set_pixels(exposure.picture.data, exposure.picture.total());
    frame.set_number(exposure.number);
    stream->send(message.SerializeAsString());
  }
}

}  // namespace armsight::sim
