#include "host/marker.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>

#include "host/edge_refine.hpp"
#include "protocol/config_error.hpp"

#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#define ARMSIGHT_ARUCO_IN_OBJDETECT 1
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#define ARMSIGHT_ARUCO_IN_OBJDETECT 0
#include <opencv2/aruco.hpp>
#endif

namespace armsight::host {
namespace {

constexpr double kNoisy_levels = 3.0;

#if ARMSIGHT_ARUCO_IN_OBJDETECT
using Dictionary = cv::aruco::Dictionary;
Dictionary predefined(int name) { return cv::aruco::getPredefinedDictionary(name); }
const Dictionary& content(const Dictionary& dictionary) { return dictionary; }
Dictionary of_bits(const cv::Mat& bytes, int side) { return Dictionary(bytes, side, 0); }
#else
using Dictionary = cv::Ptr<cv::aruco::Dictionary>;
Dictionary predefined(int name) { return cv::aruco::getPredefinedDictionary(name); }
const cv::aruco::Dictionary& content(const Dictionary& dictionary) { return *dictionary; }
Dictionary of_bits(const cv::Mat& bytes, int side) { return cv::makePtr<cv::aruco::Dictionary>(bytes, side, 0); }
#endif

int dictionary_number(const std::string& name) {
  using namespace cv::aruco;
  static const std::map<std::string, int> kNames = {
      {"DICT_4X4_50", DICT_4X4_50},     {"DICT_4X4_100", DICT_4X4_100},   {"DICT_4X4_250", DICT_4X4_250},
      {"DICT_4X4_1000", DICT_4X4_1000}, {"DICT_5X5_50", DICT_5X5_50},     {"DICT_5X5_100", DICT_5X5_100},
      {"DICT_5X5_250", DICT_5X5_250},   {"DICT_5X5_1000", DICT_5X5_1000}, {"DICT_6X6_50", DICT_6X6_50},
      {"DICT_6X6_100", DICT_6X6_100},   {"DICT_6X6_250", DICT_6X6_250},   {"DICT_6X6_1000", DICT_6X6_1000},
      {"DICT_APRILTAG_36h11", DICT_APRILTAG_36h11}};
  const auto found = kNames.find(name);
  if (found == kNames.end()) {
    std::string known;
    for (const auto& [text, number] : kNames) known += " " + text;
    throw ConfigError("dictionary = " + name + ": must be one of" + known);
  }
  return found->second;
}

/// minMarkerDistanceRate: with its default of 0.05 near markers in a narrow white margin are lost (the plate's outline
/// wins), with 0.02 still one of the chessboard photographs; doubles are dropped afterwards. Few bits may be wrong, so
/// that clutter gets no id.
template <typename Parameters>
void tune(Parameters& parameters) {
  parameters.minMarkerDistanceRate = 0.01;
  parameters.minMarkerPerimeterRate = 0.02;
  parameters.perspectiveRemovePixelPerCell = 8;
  parameters.errorCorrectionRate = 0.6;
  parameters.cornerRefinementMethod = static_cast<decltype(parameters.cornerRefinementMethod)>(0);  // ours follows
}

/// Noise of the sensor in grey levels: the median second difference along some rows, where most of a picture is flat.
double noise_levels(const cv::Mat& gray) {
  std::array<int, 1021> counts{};
  int total = 0;
  for (int row = 0; row < gray.rows; row += 8) {
    const unsigned char* line = gray.ptr(row);
    for (int x = 1; x + 1 < gray.cols; x += 3, ++total)
      ++counts[static_cast<std::size_t>(std::abs(line[x - 1] - 2 * line[x] + line[x + 1]))];
  }
  int median = 0;
  for (int below = counts[0]; 2 * below < total; below += counts[static_cast<std::size_t>(median)]) ++median;
  return median / (0.6745 * std::sqrt(6.0));
}

bool is_same_place(const MarkerDetection& a, const MarkerDetection& b) {
  const auto centre = [](const MarkerDetection& m) {
    return 0.25 * (m.corners_px[0] + m.corners_px[1] + m.corners_px[2] + m.corners_px[3]);
  };
  const cv::Point2d off = centre(a) - centre(b), side = a.corners_px[1] - a.corners_px[0];
  return off.dot(off) < 0.25 * side.dot(side);
}

/// A plate's outline around a marker is read as the same marker: what has a clean outline of its own stays.
void drop_doubles(std::vector<MarkerDetection>& found) {
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return (a.edge_rms_px > 0.0) > (b.edge_rms_px > 0.0); });
  std::vector<MarkerDetection> kept;
  for (const MarkerDetection& marker : found) {
    const bool is_double = std::any_of(kept.begin(), kept.end(), [&](const MarkerDetection& other) {
      return other.id == marker.id && is_same_place(other, marker);
    });
    if (!is_double) kept.push_back(marker);
  }
  found = std::move(kept);
}

}  // namespace

struct MarkerDetector::Impl {
  Dictionary dictionary;

  void find(const cv::Mat& gray, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& ids) const {
#if ARMSIGHT_ARUCO_IN_OBJDETECT
    cv::aruco::DetectorParameters parameters;
    tune(parameters);
    cv::aruco::ArucoDetector(dictionary, parameters).detectMarkers(gray, corners, ids);
#else
    const cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
    tune(*parameters);
    cv::aruco::detectMarkers(gray, dictionary, corners, ids, parameters);
#endif
  }
};

MarkerDetector::MarkerDetector(const std::string& dictionary)
    : impl_(new Impl{predefined(dictionary_number(dictionary))}) {}

MarkerDetector::MarkerDetector(int side_modules, const std::vector<std::string>& bits) {
  cv::Mat bytes;
  for (const std::string& text : bits) {
    if (side_modules < 3 || text.size() != static_cast<std::size_t>(side_modules * side_modules)) {
      throw ConfigError("dictionary: " + text + ": must have " + std::to_string(side_modules) + "² bits");
    }
    cv::Mat modules(side_modules, side_modules, CV_8UC1);
    for (std::size_t i = 0; i < text.size(); ++i) modules.data[i] = text[i] == '1' ? 1 : 0;
    bytes.push_back(cv::aruco::Dictionary::getByteListFromBits(modules));
  }
  impl_.reset(new Impl{of_bits(bytes, side_modules)});
}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;

std::vector<MarkerDetection> MarkerDetector::detect(const cv::Mat& image, const Intrinsics& intrinsics,
                                                    const std::optional<cv::Rect>& region) const {
  cv::Mat gray = image;
  if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  const cv::Rect whole(0, 0, gray.cols, gray.rows);
  const cv::Rect searched = region ? *region & whole : whole;
  if (searched.width < 16 || searched.height < 16) return {};
  // Noise multiplies contour candidates and time (25 ms and more at 5 levels): then search on a smoothed copy, though
  // that closes narrow gaps between black squares. Corners are refined on the original in any case.
  cv::Mat search = gray(searched);
  if (noise_levels(search) > kNoisy_levels) {
    cv::Mat smooth;
    cv::GaussianBlur(search, smooth, cv::Size(3, 3), 0.0);
    search = smooth;
  }
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  impl_->find(search, corners, ids);

  std::vector<MarkerDetection> found;
  const int modules = content(impl_->dictionary).markerSize + 2;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MarkerDetection marker{ids[i], {}, 0.0};
    for (std::size_t c = 0; c < 4; ++c) {
      marker.corners_px[c] = cv::Point2d(corners[i][c]) + cv::Point2d(searched.tl());
    }
    if (const auto refined = refine_corners(gray, intrinsics, marker.corners_px, modules)) {
      marker.corners_px = refined->corners_px;
      marker.edge_rms_px = refined->edge_rms_px;
    }
    found.push_back(marker);
  }
  drop_doubles(found);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return found;
}

MarkerPattern marker_pattern(const std::string& dictionary, int id) {
  const Dictionary stored = predefined(dictionary_number(dictionary));
  const auto& words = content(stored);
  if (id < 0 || id >= words.bytesList.rows) {
    throw ConfigError("marker id = " + std::to_string(id) + ": " + dictionary + " has 0 to " +
                      std::to_string(words.bytesList.rows - 1));
  }
  const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(words.bytesList.row(id), words.markerSize);
  MarkerPattern pattern;
  pattern.modules = words.markerSize + 2;
  pattern.is_white.assign(static_cast<std::size_t>(pattern.modules * pattern.modules), false);
  for (int row = 0; row < bits.rows; ++row) {
    for (int column = 0; column < bits.cols; ++column) {
      pattern.is_white[static_cast<std::size_t>((row + 1) * pattern.modules + column + 1)] =
          bits.at<unsigned char>(row, column) != 0;
    }
  }
  return pattern;
}

}  // namespace armsight::host
