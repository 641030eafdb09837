// What the camera saw, with what was made of it drawn in: corners, axes, one line of words. For people.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "host/grasp_table.hpp"
#include "host/look.hpp"

namespace armsight::host {

/// Outline of the marker and the axes of M (x red, y green, z blue) of a measured carrier pose T_C_X with mount T_X_M.
cv::Mat draw_look(const cv::Mat& picture, const LookMeasurement& look, const MarkerConfig& marker, const Pose& T_X_M,
                  const Intrinsics& intrinsics, const std::string& words);
/// The picture alone with words: nothing was found.
cv::Mat draw_words(const cv::Mat& picture, const std::string& words);

}  // namespace armsight::host
