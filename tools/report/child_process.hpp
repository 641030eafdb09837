// A program of ours, started as a process of its own: its lines, its end. Ended only through its own pid.
#pragma once

#include <sys/types.h>

#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace armsight::demo {

class ChildProcess {
 public:
  /// Starts the program; throws std::runtime_error when it cannot. Standard output and error come together, by line.
  ChildProcess(std::string name, const std::vector<std::string>& command);
  /// Still running: SIGTERM, two seconds of patience, SIGKILL.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Reads what has been written, without blocking; complete lines go to `on_line`.
  void drain(const std::function<void(const std::string&)>& on_line);
  /// Exit code once the process has ended (128 + number for a signal), nullopt while it runs. Never blocks.
  std::optional<int> exit_code();
  void send_signal(int number);
  /// SIGTERM, patience, SIGKILL; returns the exit code.
  int end(int patience_ms = 2000);

  const std::string& name() const { return name_; }
  const std::string& command_line() const { return command_line_; }
  int descriptor() const { return pipe_; }
  pid_t pid() const { return pid_; }
  /// The last lines, for the message that says why a program is gone.
  std::string last_lines() const;
  /// The first line that starts with `prefix`, without it.
  std::optional<std::string> line_after(const std::string& prefix) const;
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::string name_, command_line_, partial_;
  pid_t pid_ = -1;
  int pipe_ = -1;
  std::optional<int> exit_code_;
  std::vector<std::string> lines_;
};

}  // namespace armsight::demo
