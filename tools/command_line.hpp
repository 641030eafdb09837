// The command line of a tool: options in, plain values out. CLI11 stays in command_line.cpp: who includes it
// compiles for 14 s longer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace armsight::tools {

/// One option as declared; its rules are added by chaining.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option& required();
  Option& one_of(const std::vector<std::string>& values);
  Option& between(double least, double most);
  Option& positive();
  Option& existing_folder();
  Option& show_default();

 private:
  CLI::Option* option_;
};

class CommandLine {
 public:
  CommandLine(const std::string& description, const std::string& program);
  ~CommandLine();

  /// NAME as "--name" or, for an argument by its place, "NAME". parse() fills `value`, which must live till then.
  Option add(const std::string& name, std::string& value, const std::string& help);
  Option add(const std::string& name, std::filesystem::path& value, const std::string& help);
  Option add(const std::string& name, int& value, const std::string& help);
  Option add(const std::string& name, std::uint64_t& value, const std::string& help);
  Option add(const std::string& name, std::optional<double>& value, const std::string& help);
  /// Given any number of times, one value each.
  Option add(const std::string& name, std::vector<std::string>& values, const std::string& help);
  Option add(const std::string& name, bool& value, const std::string& help);

  /// The exit code to leave with: 0 after --help, 2 for a line that cannot be taken; none: all is well.
  std::optional<int> parse(int argc, const char* const* argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace armsight::tools
