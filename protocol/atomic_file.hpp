// A file that is either the old one or the whole new one, whatever happens in between.
#pragma once

#include <filesystem>
#include <string_view>

namespace armsight {

/// kUnsynced survives a crash of the program, not of the machine; syncing waits for the disk, seconds on a busy one.
enum class Durability { kSynced, kUnsynced };

/// Writes a temporary file in the same folder, syncs it, renames it over `path` and syncs the folder.
/// Throws std::runtime_error "PATH: cannot be written: reason"; `path` is then as it was.
void write_file_atomically(const std::filesystem::path& path, std::string_view text,
                           Durability durability = Durability::kSynced);

}  // namespace armsight
