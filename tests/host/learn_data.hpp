// Other people's data sets, converted into a folder of the test's own. ARMSIGHT_DATA says where they lie (default:
// ../shared/data beside the sources); absent ones skip visibly, or fail under ARMSIGHT_REQUIRE_DATA=1.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "host/learn_dataset.hpp"
#include "tools/convert/convert.hpp"

namespace armsight::test {

inline std::filesystem::path data_folder() {
  const char* named = std::getenv("ARMSIGHT_DATA");
  return named ? std::filesystem::path(named) : std::filesystem::path(ARMSIGHT_SOURCE_DIR) / ".." / "shared" / "data";
}

/// True when the set is there; otherwise the reason stands in `why` and ARMSIGHT_REQUIRE_DATA decides skip or failure.
inline bool has_data(const std::string& set, std::string& why) {
  why = (data_folder() / set).string() + " is not there: set ARMSIGHT_DATA to the folder with the public data sets";
  return std::filesystem::is_directory(data_folder() / set);
}
inline bool must_have_data() {
  const char* required = std::getenv("ARMSIGHT_REQUIRE_DATA");
  return required && std::string(required) == "1";
}

/// A folder that goes with the test.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "armsight_learn_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace armsight::test

#define ARMSIGHT_NEED_DATA(set)                                      \
  do {                                                               \
    std::string why;                                                 \
    if (armsight::test::has_data(set, why)) break;                   \
    if (armsight::test::must_have_data()) FAIL() << why;             \
    GTEST_SKIP() << why;                                             \
  } while (false)
