// A camera of the machine (V4L2 through OpenCV) behind the camera seam.
#pragma once

#include "host/camera.hpp"

namespace armsight::host {

/// Throws CameraLost when the device is missing or does not deliver the size of the intrinsics.
std::unique_ptr<Camera> make_v4l2_camera(const std::string& device, const Intrinsics& intrinsics, net::Clock& clock);

}  // namespace armsight::host
