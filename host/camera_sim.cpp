#include "host/camera_sim.hpp"

#include <cstring>
#include <deque>

#include "protocol/camera_stream.pb.h"
#include "protocol/config_error.hpp"
#include "protocol/transport/framed_stream.hpp"

namespace armsight::host {
namespace {

constexpr Duration kConnectTimeout = std::chrono::seconds(5);
constexpr Duration kHelloTimeout = std::chrono::seconds(5);  // of the clock in use

Intrinsics from_wire(const wire::Intrinsics& in) {
  Intrinsics k{static_cast<int>(in.width_px()), static_cast<int>(in.height_px()), in.fx_px(), in.fy_px(),
               in.cx_px(), in.cy_px(), {}};
  if (in.distortion_size() != static_cast<int>(k.plumb_bob.size())) {
    throw CameraLost("camera: announced " + std::to_string(in.distortion_size()) + " lens numbers: must be 5");
  }
  std::copy(in.distortion().begin(), in.distortion().end(), k.plumb_bob.begin());
  if (const std::string rule = broken_rule(k); !rule.empty()) throw CameraLost("camera: announced " + rule);
  return k;
}

class SimCamera final : public Camera {
 public:
  SimCamera(const std::string& address, const std::optional<Intrinsics>& intrinsics, net::Clock& clock)
      : name_("sim:" + address), override_(intrinsics) {
    net::StreamOptions options;
    options.type = wire::FrameType::kCamera;
    options.max_incoming = wire::kMaxCameraFrame;
    stream_ = net::connect_tcp(address, options, clock, kConnectTimeout);
    stream_->set_channel({net::ChannelKind::kCamera, 0});
    wire::CameraMessage hello;
    hello.mutable_hello()->set_sim_participant(clock.participant());
    send(hello);
    const Time until = clock.now() + kHelloTimeout;
    while (!is_announced_) {
      if (clock.now() > until) throw CameraLost(name_ + ": does not announce itself as a camera");
      clock.wait_next_cycle();
      take_messages();
    }
  }

  const Intrinsics& intrinsics() const override { return intrinsics_; }
  std::string name() const override { return name_; }

  void request(int frames) override {
    wire::CameraMessage message;
    message.mutable_frame_request()->set_frames(static_cast<std::uint32_t>(std::max(frames, 0)));
    send(message);
  }

  std::optional<Frame> poll() override {
    take_messages();
    if (frames_.empty()) return std::nullopt;
    Frame frame = std::move(frames_.front());
    frames_.pop_front();
    return frame;
  }

 private:
  void send(const wire::CameraMessage& message) {
    if (!stream_->send(message.SerializeAsString())) throw CameraLost(name_ + ": " + stream_->close_reason());
  }

  void take_messages() {
    for (const net::Received& received : stream_->receive()) {
      wire::CameraMessage message;
      if (!message.ParseFromString(received.payload)) throw CameraLost(name_ + ": sent what is no camera message");
      if (message.has_hello()) {
        intrinsics_ = override_.value_or(from_wire(message.hello().intrinsics()));
        is_announced_ = true;
      }
      if (message.has_frame()) take_frame(message.frame());
    }
    if (!stream_->is_open() && frames_.empty()) throw CameraLost(name_ + ": " + stream_->close_reason());
  }

  void take_frame(const wire::Frame& in) {
    const int type = in.format() == wire::PIXEL_FORMAT_BGR8 ? CV_8UC3 : CV_8UC1;
    const int width = static_cast<int>(in.width_px()), height = static_cast<int>(in.height_px());
    const std::size_t bytes = std::size_t{in.width_px()} * in.height_px() * (type == CV_8UC3 ? 3 : 1);
    if (in.format() == wire::PIXEL_FORMAT_UNSPECIFIED || width != intrinsics_.width || height != intrinsics_.height ||
        in.pixels().size() != bytes) {
      throw CameraLost(name_ + ": sent a frame of another format or size than announced");
    }
    Frame frame{cv::Mat(height, width, type), time_from_ns(in.capture_time_ns()), in.number()};
    std::memcpy(frame.gray_or_bgr.data, in.pixels().data(), bytes);
    frames_.push_back(std::move(frame));
  }

  std::string name_;
  std::optional<Intrinsics> override_;
  std::unique_ptr<net::FramedStream> stream_;
  Intrinsics intrinsics_;
  bool is_announced_ = false;
  std::deque<Frame> frames_;
};

}  // namespace

std::unique_ptr<Camera> make_sim_camera(const std::string& address, const std::optional<Intrinsics>& intrinsics,
                                        net::Clock& clock) {
  try {
    return std::make_unique<SimCamera>(address, intrinsics, clock);
  } catch (const ConfigError&) {
    throw;
  } catch (const CameraLost&) {
    throw;
  } catch (const net::ClockLost&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw CameraLost(error.what());
  }
}

}  // namespace armsight::host
