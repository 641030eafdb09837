#include "tools/report/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace armsight::demo {

namespace {

constexpr int kCannotExecute = 127;

[[noreturn]] void become(const std::vector<std::string>& command, int output, pid_t parent) {
  // A group of its own: Ctrl-C at the terminal reaches the demo alone, which then ends its children in order.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kCannotExecute);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& a : command) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  dprintf(STDERR_FILENO, "cannot start %s: %s\n", arguments[0], std::strerror(errno));
  _exit(kCannotExecute);
}

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::vector<std::string>& command) : name_(std::move(name)) {
  for (const std::string& word : command) command_line_ += (command_line_.empty() ? "" : " ") + word;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(command, ends[1], parent);
  close(ends[1]);
  if (pid_ < 0) {
    close(ends[0]);
    throw std::runtime_error("cannot start " + name_ + ": " + std::strerror(errno));
  }
  pipe_ = ends[0];
  fcntl(pipe_, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() {
  end();
  close(pipe_);
}

void ChildProcess::drain(const std::function<void(const std::string&)>& on_line) {
  std::array<char, 4096> bytes{};
  for (ssize_t n = 0; (n = read(pipe_, bytes.data(), bytes.size())) > 0;) {
    partial_.append(bytes.data(), static_cast<std::size_t>(n));
  }
  for (std::size_t end = 0; (end = partial_.find('\n')) != std::string::npos;) {
    lines_.push_back(partial_.substr(0, end));
    partial_.erase(0, end + 1);
    if (on_line) on_line(lines_.back());
  }
}

std::optional<int> ChildProcess::exit_code() {
  int status = 0;
  if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return exit_code_;
}

void ChildProcess::send_signal(int number) {
  if (!exit_code()) kill(pid_, number);
}

int ChildProcess::end(int patience_ms) {
  send_signal(SIGTERM);
  for (int waited_ms = 0; !exit_code() && waited_ms < patience_ms; waited_ms += 10) {
    drain({});  // a full pipe would keep it from ending
    poll(nullptr, 0, 10);
  }
  send_signal(SIGKILL);
  while (!exit_code()) poll(nullptr, 0, 1);
  return *exit_code_;
}

std::string ChildProcess::last_lines() const {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = lines_.size() - std::min(kShown, lines_.size()); i < lines_.size(); ++i) {
    text += "  | " + lines_[i] + "\n";
  }
  return text;
}

std::optional<std::string> ChildProcess::line_after(const std::string& prefix) const {
  for (const std::string& line : lines_) {
    if (line.starts_with(prefix)) return line.substr(prefix.size());
  }
  return std::nullopt;
}

}  // namespace armsight::demo
