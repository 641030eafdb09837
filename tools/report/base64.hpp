// Base64 (RFC 4648), for pictures inside the report.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace armsight::demo {

std::string base64(std::string_view bytes);
/// Throws std::runtime_error when the file cannot be read.
std::string base64_of_file(const std::filesystem::path& file);

}  // namespace armsight::demo
