// The simulated camera's stream (protocol/camera_stream.proto) behind the camera seam.
#pragma once

#include "host/camera.hpp"

namespace armsight::host {

/// Connects and waits (cycles of the clock) for the announcement; `intrinsics` replaces the announced ones.
std::unique_ptr<Camera> make_sim_camera(const std::string& address, const std::optional<Intrinsics>& intrinsics,
                                        net::Clock& clock);

}  // namespace armsight::host
