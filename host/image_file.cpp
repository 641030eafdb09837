#include <opencv2/imgcodecs.hpp>

#include "host/overlay.hpp"

namespace armsight::host {

void save_image(const std::filesystem::path& file, const cv::Mat& image) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  bool is_written = false;
  try {
    is_written = cv::imwrite(file.string(), image, {cv::IMWRITE_JPEG_QUALITY, 88});
  } catch (const cv::Exception& error) {
    throw std::runtime_error(file.string() + ": cannot be written: " + error.err);
  }
  if (!is_written) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace armsight::host
