#include "host/session_files.hpp"

#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "host/overlay.hpp"
#include "protocol/atomic_file.hpp"
#include "protocol/config_error.hpp"

namespace armsight::host {
namespace fs = std::filesystem;
namespace {

constexpr const char* kProbe = ".writable";

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw ConfigError("--state: " + folder.string() + ": cannot be made: " + error.message());
}

}  // namespace

SessionFiles::SessionFiles(const fs::path& state, const std::string& verb) : state_(state), verb_(verb) {
  make_folder(state_ / "images");
  try {  // a read-only folder shows now, not when the arm has moved
    write_file_atomically(state_ / kProbe, {}, Durability::kUnsynced);
    fs::remove(state_ / kProbe);
  } catch (const std::runtime_error& error) {
    throw ConfigError(std::string("--state: ") + error.what());
  }
}

// Not before there is something new to keep: a run that ends early leaves the last one's pictures to its result.
void SessionFiles::forget_last_run() {
  if (std::exchange(has_forgotten_, true)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(state_ / "images")) {
    if (entry.path().filename().string().starts_with(verb_ + "-")) fs::remove(entry.path());
  }
}

void SessionFiles::save_result(std::string_view json) {
  forget_last_run();
  write_file_atomically(state_ / (verb_ + ".json"), json, Durability::kUnsynced);
}

std::string SessionFiles::save_picture(const cv::Mat& picture) {
  if (picture.empty()) return {};
  forget_last_run();
  char name[64];
  std::snprintf(name, sizeof name, "-%02zu.jpg", pictures_.size() + 1);
  const std::string relative = "images/" + verb_ + name;
  save_image(state_ / relative, picture);
  pictures_.push_back(relative);
  return relative;
}

}  // namespace armsight::host
