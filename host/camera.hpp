// The one seam to a camera: frames come when asked for, stamped with the middle of their exposure in the host's clock.
// Sources: the simulator's stream, a V4L2 device, a video file, a folder of pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "host/intrinsics.hpp"
#include "protocol/transport/clock.hpp"
#include "shared/time.hpp"

namespace armsight::host {

struct Frame {
  cv::Mat gray_or_bgr;  ///< CV_8UC1 or CV_8UC3, of the intrinsics' size
  Time capture_time;    ///< middle of the exposure, host clock
  std::uint64_t number = 0;
};

/// The stream ended for a reason the caller cannot repair: the peer is gone, the device was pulled (exit code 3).
class CameraLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Camera {
 public:
  virtual ~Camera() = default;
  virtual const Intrinsics& intrinsics() const = 0;
  /// The next so many exposures from now; frames not asked for never come. A new request replaces the old one.
  virtual void request(int frames) = 0;
  /// Non-blocking, once a cycle. nullopt: nothing has come. Throws CameraLost. Lockstep: exactly what is due.
  virtual std::optional<Frame> poll() = 0;
  /// A file source that has given its last frame; live cameras never end.
  virtual bool is_at_end() const { return false; }
  virtual std::string name() const = 0;
};

/// "sim:ADDR:PORT" | "v4l2:/dev/videoN" | "video:FILE" | "folder:DIR". The intrinsics file may be left empty for sim
/// only, which announces its own. Throws ConfigError (bad words or files) or CameraLost (no such device, nobody there).
/// sim waits cycles of the clock for the announcement: make the camera before other streams on the same clock.
std::unique_ptr<Camera> make_camera(const std::string& source, const std::filesystem::path& intrinsics_file,
                                    net::Clock& clock);

}  // namespace armsight::host
