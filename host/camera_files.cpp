#include "host/camera_files.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "protocol/config.hpp"

namespace armsight::host {
namespace {

constexpr Duration kFramePeriod = std::chrono::nanoseconds(33'333'333);

void check_size(const cv::Mat& image, const Intrinsics& k, const std::string& where) {
  if (image.cols == k.width && image.rows == k.height) return;
  throw ConfigError(where + ": picture of " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                    " px: must be " + std::to_string(k.width) + " x " + std::to_string(k.height) +
                    " as the intrinsics say");
}

/// Request, pace and numbering, the same for every file source.
class FileCamera : public Camera {
 public:
  FileCamera(std::string name, const Intrinsics& intrinsics, net::Clock& clock)
      : name_(std::move(name)), intrinsics_(intrinsics), clock_(clock), next_(clock.now()) {}

  const Intrinsics& intrinsics() const override { return intrinsics_; }
  std::string name() const override { return name_; }
  void request(int frames) override { wanted_ = std::max(frames, 0); }
  bool is_at_end() const override { return is_at_end_; }

  std::optional<Frame> poll() override {
    const Time now = clock_.now();
    if (wanted_ == 0 || is_at_end_ || now < next_) return std::nullopt;
    next_ = now + kFramePeriod;
    cv::Mat image = read();
    if (image.empty()) {
      is_at_end_ = true;
      return std::nullopt;
    }
    check_size(image, intrinsics_, name_);
    --wanted_;
    return Frame{std::move(image), now, ++number_};
  }

 protected:
  /// The next picture; empty at the end.
  virtual cv::Mat read() = 0;

 private:
  std::string name_;
  Intrinsics intrinsics_;
  net::Clock& clock_;
  Time next_;
  int wanted_ = 0;
  bool is_at_end_ = false;
  std::uint64_t number_ = 0;
};

bool is_picture(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg" || extension == ".pgm" ||
         extension == ".bmp" || extension == ".tif" || extension == ".tiff";
}

class FolderCamera final : public FileCamera {
 public:
  FolderCamera(const std::filesystem::path& folder, const Intrinsics& intrinsics, net::Clock& clock)
      : FileCamera("folder:" + folder.string(), intrinsics, clock) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (is_picture(entry.path())) files_.push_back(entry.path());
    }
    if (error) throw ConfigError(folder.string() + ": cannot be read: " + error.message());
    if (files_.empty()) throw ConfigError(folder.string() + ": holds no picture (png, jpg, pgm, bmp, tif)");
    std::sort(files_.begin(), files_.end());
  }

 private:
  cv::Mat read() override {
    if (next_file_ == files_.size()) return {};
    const std::filesystem::path& file = files_[next_file_++];
    cv::Mat image = cv::imread(file.string(), cv::IMREAD_COLOR);
    if (image.empty()) throw ConfigError(file.string() + ": is no picture that can be read");
    return image;
  }

  std::vector<std::filesystem::path> files_;
  std::size_t next_file_ = 0;
};

class VideoCamera final : public FileCamera {
 public:
  VideoCamera(const std::filesystem::path& file, const Intrinsics& intrinsics, net::Clock& clock)
      : FileCamera("video:" + file.string(), intrinsics, clock) {
    if (!std::filesystem::is_regular_file(file)) throw ConfigError(file.string() + ": is no file");
    if (!capture_.open(file.string())) throw ConfigError(file.string() + ": is no video that can be read");
  }

 private:
  cv::Mat read() override {
    cv::Mat image;
    capture_.read(image);
    return image;
  }

  cv::VideoCapture capture_;
};

}  // namespace

std::unique_ptr<Camera> make_folder_camera(const std::filesystem::path& folder, const Intrinsics& intrinsics,
                                           net::Clock& clock) {
  return std::make_unique<FolderCamera>(folder, intrinsics, clock);
}

std::unique_ptr<Camera> make_video_camera(const std::filesystem::path& file, const Intrinsics& intrinsics,
                                          net::Clock& clock) {
  return std::make_unique<VideoCamera>(file, intrinsics, clock);
}

}  // namespace armsight::host
