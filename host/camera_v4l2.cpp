#include "host/camera_v4l2.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <thread>

namespace armsight::host {
namespace {

/// A thread reads, because the driver blocks for up to a frame; poll() takes the newest picture since the request.
class V4l2Camera final : public Camera {
 public:
  V4l2Camera(const std::string& device, const Intrinsics& intrinsics, net::Clock& clock)
      : name_("v4l2:" + device), intrinsics_(intrinsics), clock_(clock) {
    if (!std::filesystem::exists(device)) throw CameraLost(name_ + ": no such device");
    if (!capture_.open(device, cv::CAP_V4L2)) throw CameraLost(name_ + ": cannot be opened (in use, or no camera)");
    capture_.set(cv::CAP_PROP_FRAME_WIDTH, intrinsics.width);
    capture_.set(cv::CAP_PROP_FRAME_HEIGHT, intrinsics.height);
    capture_.set(cv::CAP_PROP_BUFFERSIZE, 1);
    const int width = static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH));
    const int height = static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT));
    if (width != intrinsics.width || height != intrinsics.height) {
      throw CameraLost(name_ + ": delivers " + std::to_string(width) + " x " + std::to_string(height) +
                       " px: must be " + std::to_string(intrinsics.width) + " x " + std::to_string(intrinsics.height));
    }
    reader_ = std::jthread([this](const std::stop_token& stop) { read(stop); });
  }

  const Intrinsics& intrinsics() const override { return intrinsics_; }
  std::string name() const override { return name_; }

  void request(int frames) override {
    const std::lock_guard lock(mutex_);
    wanted_ = std::max(frames, 0);
    requested_ = clock_.now();
    newest_.reset();
  }

  std::optional<Frame> poll() override {
    const std::lock_guard lock(mutex_);
    if (!newest_) {
      if (is_lost_) throw CameraLost(name_ + ": stopped delivering frames");
      return std::nullopt;
    }
    std::optional<Frame> frame = std::move(newest_);
    newest_.reset();
    --wanted_;
    return frame;
  }

 private:
  void read(const std::stop_token& stop) {
    for (std::uint64_t number = 1; !stop.stop_requested(); ++number) {
      cv::Mat image;
      if (!capture_.read(image) || image.empty()) {
        const std::lock_guard lock(mutex_);
        is_lost_ = true;
        return;
      }
      const Time captured = stamp();
      const std::lock_guard lock(mutex_);
      if (wanted_ > 0 && captured >= requested_) newest_ = Frame{std::move(image), captured, number};
    }
  }

  /// V4L2 stamps the end of a frame in CLOCK_MONOTONIC ms, as CAP_PROP_POS_MSEC; without it, the time of reading. The
  /// host clock runs at the monotonic rate: only the age is taken from it. Half the exposure is not known here.
  Time stamp() {
    const Time now = clock_.now();
    timespec monotonic{};
    clock_gettime(CLOCK_MONOTONIC, &monotonic);
    const double now_ms = static_cast<double>(monotonic.tv_sec) * 1e3 + static_cast<double>(monotonic.tv_nsec) * 1e-6;
    const double age_ms = now_ms - capture_.get(cv::CAP_PROP_POS_MSEC);
    return age_ms >= 0.0 && age_ms < 500.0 ? now - seconds_to_duration(age_ms * 1e-3) : now;
  }

  std::string name_;
  Intrinsics intrinsics_;
  net::Clock& clock_;
  cv::VideoCapture capture_;
  std::mutex mutex_;
  int wanted_ = 0;
  Time requested_;
  std::optional<Frame> newest_;
  bool is_lost_ = false;
  std::jthread reader_;  // last: joined before what it uses goes
};

}  // namespace

std::unique_ptr<Camera> make_v4l2_camera(const std::string& device, const Intrinsics& intrinsics, net::Clock& clock) {
  return std::make_unique<V4l2Camera>(device, intrinsics, clock);
}

}  // namespace armsight::host
