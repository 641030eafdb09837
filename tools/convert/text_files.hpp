// Lines in, lines out, for the converters; errors are ConfigError with file and line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/convert/convert.hpp"

namespace armsight::tools {

std::vector<std::string> read_lines(const Path& file);
std::vector<std::string> split(std::string_view text, char separator);  ///< fields trimmed of blanks
std::string join(const std::vector<std::string>& fields);               ///< by commas
/// Throws ConfigError unless the text is one finite number.
const std::string& checked_number(const std::string& text, const Path& file, std::size_t line);
void write_file(const Path& file, const std::string& content);
[[noreturn]] void refuse(const Path& file, std::size_t line, const std::string& rule);

}  // namespace armsight::tools
