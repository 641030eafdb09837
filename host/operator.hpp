// Who answers what only eyes on the arm can know: a person at the terminal, or a file of answers (scripts, tests).
#pragma once

#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "protocol/config.hpp"

namespace armsight::host {

/// `key` names the question in a file of answers, `text` asks a person. Throw CommandFailed where no answer comes.
class Operator {
 public:
  virtual ~Operator() = default;
  virtual bool ask_yes(const std::string& joint, const std::string& key, const std::string& text) = 0;
  virtual double ask_deg(const std::string& joint, const std::string& key, const std::string& text) = 0;
  virtual std::pair<double, double> ask_range_deg(const std::string& joint, const std::string& key,
                                                  const std::string& text) = 0;
};

/// YAML, a mapping a joint; read strictly, all violations at once (ConfigError):
///   elbow_flexion: {here_deg: 12.5, positive: true, up_deg: 14.5, down_deg: 10.5, free_deg: [-5, 140]}
std::unique_ptr<Operator> read_answers(const std::string& file, const std::vector<std::string>& joints);

/// Questions on `out`, answers from the descriptor, a line each. While a person thinks, `meanwhile` is called again and
/// again (the lease must live). What cannot be read is asked again, three times; "q" or the end of the input gives up.
std::unique_ptr<Operator> make_terminal_operator(int descriptor, std::ostream& out, std::function<void()> meanwhile);

}  // namespace armsight::host
