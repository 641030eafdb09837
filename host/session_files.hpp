// What the host leaves behind, under --state DIR: the latest result of each verb, pictures with overlay, the looks of
// a calibration as they are made, the calibration itself. Every file is written beside its name and renamed: a reader
// never sees half of one. Only the calibration waits for the disk: what can be looked at anew need not
// outlive a power cut.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>


namespace armsight::host {

class SessionFiles {
 public:
  /// Makes the folder and tries to write there; throws ConfigError where it cannot. Nothing of the last run is touched
  /// until there is something new. `verb` names the pictures and the result.
  SessionFiles(const std::filesystem::path& state, const std::string& verb);

  const std::filesystem::path& folder() const { return state_; }
  /// STATE/VERB.json. What cannot be written any more, the arm having moved, is no bad flag:
  /// std::runtime_error, exit 1.
  void save_result(std::string_view json);
  /// STATE/images/VERB-NN.jpg; answers the name relative to STATE, empty without a picture.
  std::string save_picture(const cv::Mat& picture);
  const std::vector<std::string>& pictures() const { return pictures_; }

 private:
  void forget_last_run();

  std::filesystem::path state_;
  std::string verb_;
  bool has_forgotten_ = false;
  std::vector<std::string> pictures_;
};

}  // namespace armsight::host
