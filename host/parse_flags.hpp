// How every program with CLI11 reads its command line: 0 after --help, 2 for a line that cannot be taken. CLI11 names a
// missing option before an unknown one; a mistyped option looks like both, and only its name tells the user which.
// Header only, for the one file of each program that knows CLI11.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace armsight::host {

/// The exit code to leave with; none: all is well and the options are filled.
inline std::optional<int> parse_flags(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::RequiredError& missing) {
    const std::vector<std::string> unknown = app.remaining(true);
    if (unknown.empty()) app.exit(missing);
    else app.exit(CLI::ExtrasError(app.get_name(), unknown));
    return 2;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
}

}  // namespace armsight::host
