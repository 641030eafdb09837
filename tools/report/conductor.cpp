#include "tools/report/conductor.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "tools/report/patience.hpp"

namespace armsight::demo {

volatile std::sig_atomic_t Conductor::is_interrupted = 0;

namespace {

constexpr int kExitPatience_ms = 10'000;

}  // namespace

Conductor::Conductor(const std::filesystem::path& log_file, bool is_verbose)
    : log_(std::fopen(log_file.c_str(), "w")),
      is_verbose_(is_verbose),
      decoder_(wire::FrameType::kSimClock, wire::kMaxSimClock) {
  if (log_ == nullptr) throw std::runtime_error(log_file.string() + ": cannot be written: " + std::strerror(errno));
}

Conductor::~Conductor() {
  if (clock_ >= 0) close(clock_);  // or a program that waits for its cycle could not hear that it shall end
  while (!children_.empty()) children_.pop_back();  // clients first, arm_sim last
  std::fclose(log_);
}

std::string Conductor::start_server(const std::string& name, const std::vector<std::string>& command,
                                    const std::string& ready_prefix) {
  hold();
  children_.push_back(std::make_unique<ChildProcess>(name, command));
  ChildProcess& child = *children_.back();
  const Patience patience(kStartPatience_ms);
  // The first server, arm_sim, owns the clock; a controller on a real bus goes by the machine's.
  bool is_joined = clock_ < 0 || std::ranges::find(command, "--clock") == command.end();
  while (true) {
    attend(kPoll_ms);
    if (!is_joined && child.line_after(name + ": joined the simulated clock")) {
      is_joined = true;
      release();  // it gets on with its first cycle, which is not over before it is ready
      hold();
    }
    if (const auto rest = child.line_after(ready_prefix); rest && is_joined) {
      servers_.push_back(name);
      return *rest;
    }
    if (child.exit_code()) lose(child, "ended while starting");
    if (patience.is_over()) lose(child, "did not come up within 120 s");
  }
}

ChildProcess& Conductor::start(const std::string& name, const std::vector<std::string>& command) {
  hold();
  const std::uint32_t before = participants_;
  children_.push_back(std::make_unique<ChildProcess>(name, command));
  ChildProcess& child = *children_.back();
  const Patience patience(kStartPatience_ms);
  while (!child.line_after(name + ": joined the simulated clock") && !child.exit_code()) {
    attend(kPoll_ms);
    if (patience.is_over()) lose(child, "did not join the simulated clock within 120 s");
  }
  if (is_lockstep_ && !child.exit_code()) {
    release();
    hold();
    if (participants_ <= before) lose(child, "joined, but the clock does not count it");
  }
  return child;
}

int Conductor::run(const std::string& name, const std::vector<std::string>& command, std::vector<std::string>* lines) {
  hold();
  const std::uint32_t before = participants_;
  ChildProcess& child = start(name, command);
  while (is_lockstep_ ? participants_ > before : !child.exit_code()) {
    release();
    if (is_lockstep_) hold();
    else attend(kPoll_ms);
  }
  wait_for_exit(child);
  const int code = *child.exit_code();
  if (lines != nullptr) *lines = child.lines();
  std::erase_if(children_, [&](const auto& c) { return c.get() == &child; });
  return code;
}

void Conductor::run_cycles(std::uint64_t cycles) {
  if (!is_lockstep_) {
    const Patience patience(static_cast<int>(4 * cycles));
    while (!patience.is_over()) attend(1, false);
    return;
  }
  for (std::uint64_t i = 0; i < cycles; ++i) {
    release();
    hold();
  }
}

int Conductor::end(const std::string& name) {
  ChildProcess* child = find(name);
  if (child == nullptr) return 0;
  std::erase(servers_, name);
  child->send_signal(SIGTERM);
  const Patience patience(kExitPatience_ms);
  while (!child->exit_code() && !patience.is_over()) {
    release();
    attend(10, false);
  }
  const int code = child->end();
  attend(0, false);
  return code;
}

void Conductor::kill(const std::string& name) {
  std::erase(servers_, name);
  std::erase_if(children_, [&](const auto& child) {
    if (child->name() != name) return false;
    child->send_signal(SIGKILL);
    child->end();
    return true;
  });
}

ChildProcess* Conductor::find(const std::string& name) {
  for (const auto& child : children_) {
    if (child->name() == name) return child.get();
  }
  return nullptr;
}

void Conductor::wait_for_exit(ChildProcess& child) {
  const Patience patience(kExitPatience_ms);
  while (!child.exit_code()) {
    attend(5);
    if (patience.is_over()) lose(child, "left the clock but does not end");
  }
  attend(0);
}

void Conductor::attend(int timeout_ms, bool must_servers_live) {
  if (is_interrupted != 0) throw Interrupted();
  std::vector<pollfd> polled;
  if (clock_ >= 0 && !is_clock_lost_) polled.push_back({clock_, POLLIN, 0});
  for (const auto& child : children_) {
    if (!child->exit_code()) polled.push_back({child->descriptor(), POLLIN, 0});
  }
  poll(polled.data(), polled.size(), timeout_ms);
  if (clock_ >= 0 && !is_clock_lost_) take_clock_messages();
  for (const auto& child : children_) {
    child->drain([&](const std::string& line) {
      std::fprintf(log_, "%s\n", line.c_str());
      if (is_verbose_) std::printf("  %s\n", line.c_str());
    });
  }
  std::fflush(log_);
  if (is_verbose_) std::fflush(stdout);
  if (!must_servers_live) return;
  for (const std::string& name : servers_) {
    ChildProcess* server = find(name);
    if (server != nullptr && server->exit_code()) lose(*server, "ended in the middle of the run");
  }
}

void Conductor::lose(ChildProcess& child, const std::string& what) {
  child.drain({});
  const auto code = child.exit_code();
  throw ProgramLost(child.name() + " " + what + (code ? " (exit code " + std::to_string(*code) + ")" : "") +
                    "; its last lines:\n" + child.last_lines());
}

}  // namespace armsight::demo
