// Pictures from files behind the camera seam: a folder of images in the order of their names, or a video file.
// A file has no exposure time of its own: pictures are stamped when they are handed out, 30 a second at most.
#pragma once

#include "host/camera.hpp"

namespace armsight::host {

std::unique_ptr<Camera> make_folder_camera(const std::filesystem::path& folder, const Intrinsics& intrinsics,
                                           net::Clock& clock);
std::unique_ptr<Camera> make_video_camera(const std::filesystem::path& file, const Intrinsics& intrinsics,
                                          net::Clock& clock);

}  // namespace armsight::host
