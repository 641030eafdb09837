#include "host/session_files.hpp"

#include <cstdio>
#include <fstream>
#include <system_error>

#include "host/overlay.hpp"
#include "protocol/config_error.hpp"

namespace armsight::host {
namespace fs = std::filesystem;
namespace {

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw ConfigError("--state: " + folder.string() + ": cannot be made: " + error.message());
}

}  // namespace

void write_atomically(const fs::path& file, std::string_view content) {
  const fs::path beside = file.string() + ".new";
  std::ofstream out(beside, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  if (!out) throw ConfigError(file.string() + ": cannot be written");
  std::error_code error;
  fs::rename(beside, file, error);
  if (error) throw ConfigError(file.string() + ": cannot be written: " + error.message());
}

SessionFiles::SessionFiles(const fs::path& state, const std::string& verb) : state_(state), verb_(verb) {
  make_folder(state_);
  make_folder(state_ / "images");
  for (const fs::directory_entry& entry : fs::directory_iterator(state_ / "images")) {
    if (entry.path().filename().string().starts_with(verb_ + "-")) fs::remove(entry.path());  // of an earlier run
  }
}

void SessionFiles::save_result(std::string_view json) const { write_atomically(state_ / (verb_ + ".json"), json); }

std::string SessionFiles::save_picture(const cv::Mat& picture) {
  if (picture.empty()) return {};
  char name[64];
  std::snprintf(name, sizeof name, "-%02zu.jpg", pictures_.size() + 1);
  const std::string relative = "images/" + verb_ + name;
  try {
    save_image(state_ / relative, picture);
  } catch (const std::runtime_error& error) {
    throw ConfigError(error.what());
  }
  pictures_.push_back(relative);
  return relative;
}

}  // namespace armsight::host
