// A file that is either the old one or the whole new one, whatever happens in between.
#pragma once

#include <filesystem>
#include <string_view>

namespace armsight {

/// Writes a temporary file in the same folder, syncs it, renames it over `path` and syncs the folder.
/// Throws std::runtime_error "PATH: cannot be written: reason"; `path` is then as it was.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace armsight
