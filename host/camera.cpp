#include "host/camera.hpp"

#include "host/camera_files.hpp"
#include "host/camera_sim.hpp"
#include "host/camera_v4l2.hpp"
#include "protocol/config.hpp"

namespace armsight::host {

std::unique_ptr<Camera> make_camera(const std::string& source, const std::filesystem::path& intrinsics_file,
                                    net::Clock& clock) {
  const std::size_t colon = source.find(':');
  const std::string kind = source.substr(0, colon);
  const std::string rest = colon == std::string::npos ? std::string() : source.substr(colon + 1);
  const bool is_known = kind == "sim" || kind == "v4l2" || kind == "video" || kind == "folder";
  if (!is_known || rest.empty()) {
    throw ConfigError("--camera: " + source + ": must be sim:ADDR:PORT, v4l2:/dev/videoN, video:FILE or folder:DIR");
  }
  std::optional<Intrinsics> intrinsics;
  if (!intrinsics_file.empty()) intrinsics = load_intrinsics(intrinsics_file);
  if (kind == "sim") return make_sim_camera(rest, intrinsics, clock);
  if (!intrinsics) throw ConfigError("--camera: " + source + ": needs an intrinsics file");
  if (kind == "v4l2") return make_v4l2_camera(rest, *intrinsics, clock);
  if (kind == "video") return make_video_camera(rest, *intrinsics, clock);
  return make_folder_camera(rest, *intrinsics, clock);
}

}  // namespace armsight::host
