#include "host/operator.hpp"

#include <poll.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <ostream>
#include <vector>

#include "host/host_io.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr double kLargestAngle_deg = 3600.0;
constexpr int kAttempts = 3;
constexpr std::size_t kLongestLine = 200;

class AnswersFile final : public Operator {
 public:
  AnswersFile(const std::string& file, const std::vector<std::string>& joints) : file_(file) {
    const StrictYaml yaml = StrictYaml::parse(read_text_file(file), file);
    for (const std::string& joint : joints) read(joint, yaml.root().key(joint));
    yaml.finish();
  }
  bool ask_yes(const std::string& joint, const std::string& key, const std::string&) override {
    return values_.at(joint + "." + key).front() != 0.0;
  }
  double ask_deg(const std::string& joint, const std::string& key, const std::string&) override {
    return values_.at(joint + "." + key).front();
  }
  std::pair<double, double> ask_range_deg(const std::string& joint, const std::string& key,
                                          const std::string&) override {
    const std::vector<double>& range = values_.at(joint + "." + key);
    return {range[0], range[1]};
  }

 private:
  void read(const std::string& joint, const YamlValue& answers) {
    for (const char* key : {"here_deg", "up_deg", "down_deg"})
      values_[joint + "." + key] = {answers.key(key).number(-kLargestAngle_deg, kLargestAngle_deg)};
    values_[joint + ".positive"] = {answers.key("positive").boolean() ? 1.0 : 0.0};
    const YamlValue range = answers.key("free_deg");
    std::vector<double>& free = values_[joint + ".free_deg"];
    free = range.numbers(2, -kLargestAngle_deg, kLargestAngle_deg);
    if (free[0] >= free[1]) range.refuse("the first must be below the second");
  }

  std::string file_;
  std::map<std::string, std::vector<double>> values_;  ///< "joint.key"
};

/// Numbers and nothing else, `count` of them.
std::optional<std::vector<double>> read_numbers(std::string_view line, std::size_t count) {
  std::vector<double> out;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t,");
    if (begin == std::string_view::npos) break;
    line.remove_prefix(begin);
    if (line.front() == '+') line.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (error != std::errc() || !std::isfinite(value) || std::abs(value) > kLargestAngle_deg) return std::nullopt;
    out.push_back(value);
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && line.front() != ' ' && line.front() != ',' && line.front() != '\t') return std::nullopt;
  }
  return out.size() == count ? std::optional(out) : std::nullopt;
}

class Terminal final : public Operator {
 public:
  Terminal(int descriptor, std::ostream& out, std::function<void()> meanwhile)
      : descriptor_(descriptor), out_(out), meanwhile_(std::move(meanwhile)) {}

  bool ask_yes(const std::string& joint, const std::string&, const std::string& text) override {
    const auto read = [](const std::string& line) -> std::optional<bool> {
      if (line == "y" || line == "yes") return true;
      return line == "n" || line == "no" ? std::optional(false) : std::nullopt;
    };
    return ask<bool>(joint, text + " [y/n]", "y or n", read);
  }
  double ask_deg(const std::string& joint, const std::string&, const std::string& text) override {
    return ask<std::vector<double>>(joint, text + " [deg]", "a number",
                                    [](const std::string& line) { return read_numbers(line, 1); })[0];
  }
  std::pair<double, double> ask_range_deg(const std::string& joint, const std::string&,
                                          const std::string& text) override {
    const auto read = [](const std::string& line) {
      const auto range = read_numbers(line, 2);
      return range && (*range)[0] < (*range)[1] ? range : std::nullopt;
    };
    const auto range = ask<std::vector<double>>(joint, text + " [deg deg]", "two numbers, the lower first", read);
    return {range[0], range[1]};
  }

 private:
  template <typename T, typename Read>
  T ask(const std::string& joint, const std::string& text, const std::string& form, const Read& read) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      out_ << joint << ": " << text << " " << std::flush;
      const std::string line = next_line(joint);
      if (line == "q") throw CommandFailed("commission: left by the operator at " + joint);
      if (const auto answer = read(line)) return *answer;
      out_ << "  must be " << form << ", or q to leave\n";
    }
    throw CommandFailed("commission: no answer that can be read for " + joint);
  }

  std::string next_line(const std::string& joint) {
    while (true) {
      if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
        std::string line = pending_.substr(0, end);
        pending_.erase(0, end + 1);
        const std::size_t first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
        return first == std::string::npos ? std::string() : line.substr(first, last - first + 1);
      }
      if (pending_.size() > kLongestLine) pending_.assign("?\n");
      pollfd ready{descriptor_, POLLIN, 0};
      if (::poll(&ready, 1, 0) > 0) {
        char bytes[128];
        const ssize_t count = ::read(descriptor_, bytes, sizeof bytes);
        if (count <= 0) throw CommandFailed("commission: the answers end at " + joint);
        pending_.append(bytes, static_cast<std::size_t>(count));
      } else {
        meanwhile_();
      }
    }
  }

  int descriptor_;
  std::ostream& out_;
  std::function<void()> meanwhile_;
  std::string pending_;
};

}  // namespace

std::unique_ptr<Operator> read_answers(const std::string& file, const std::vector<std::string>& joints) {
  return std::make_unique<AnswersFile>(file, joints);
}

std::unique_ptr<Operator> make_terminal_operator(int descriptor, std::ostream& out, std::function<void()> meanwhile) {
  return std::make_unique<Terminal>(descriptor, out, std::move(meanwhile));
}

}  // namespace armsight::host
