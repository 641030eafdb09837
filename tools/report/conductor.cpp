#include "tools/report/conductor.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>

#include "protocol/sim_clock.pb.h"

namespace armsight::demo {

volatile std::sig_atomic_t Conductor::is_interrupted = 0;

namespace {

constexpr int kStartPatience_ms = 120'000;  // in tools/hil's guest on a busy machine the host takes 40 s to start
constexpr int kExitPatience_ms = 10'000;
constexpr int kPoll_ms = 100;

/// Wall-clock patience: the only use of the machine's clock here, and only to give up.
class Patience {
 public:
  explicit Patience(int limit_ms) : end_(std::chrono::steady_clock::now() + std::chrono::milliseconds(limit_ms)) {}
  bool is_over() const { return std::chrono::steady_clock::now() > end_; }

 private:
  std::chrono::steady_clock::time_point end_;
};

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

void Conductor::join_clock(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path) throw ProgramLost("socket path too long: " + path.string());
  std::memcpy(address.sun_path, path.c_str(), path.string().size() + 1);
  clock_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(clock_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw ProgramLost("cannot join the simulated clock at " + path.string() + ": " + std::strerror(errno));
  }
  wire::SimClockMessage message;
  message.mutable_join()->set_name("demo");
  message.mutable_join()->set_role(wire::SIM_ROLE_CONDUCTOR);
  send(message);
  const Patience patience(kStartPatience_ms);
  while (!is_welcome_) {
    attend(kPoll_ms);
    if (patience.is_over()) throw ProgramLost("arm_sim does not answer on its clock");
  }
  hold();
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

void Conductor::inject_drift() {
  wire::SimClockMessage message;
  message.mutable_inject_drift();
  request(message, "the drift");
}

void Conductor::finish(const std::filesystem::path& truth_file) {
  servers_.clear();  // without a clock they end
  wire::SimClockMessage message;
  message.mutable_finish()->set_truth_file(truth_file.string());
  request(message, "the truth");
}

double Conductor::time_s() const {
  if (is_lockstep_) return static_cast<double>(cycle_) * period_s_;
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ChildProcess* Conductor::find(const std::string& name) {
  for (const auto& child : children_) {
    if (child->name() == name) return child.get();
  }
  return nullptr;
}

void Conductor::request(const wire::SimClockMessage& message, const std::string& what) {
  hold();
  is_answered_ = false;
  send(message);
  const Patience patience(kStartPatience_ms);
  while (!is_answered_) {
    if (patience.is_over() || is_clock_lost_) throw ProgramLost("arm_sim does not answer when asked for " + what);
    attend(kPoll_ms);
  }
  if (!answer_error_.empty()) throw std::runtime_error("arm_sim refused " + what + ": " + answer_error_);
}

void Conductor::hold() {
  if (!is_lockstep_ || clock_ < 0) return;
  const Patience patience(60'000);
  while (!is_grant_pending_) {
    attend(kPoll_ms);
    if (patience.is_over()) throw ProgramLost("the simulated clock stands still since cycle " + std::to_string(cycle_));
  }
}

void Conductor::release() {
  if (!is_grant_pending_) return;
  is_grant_pending_ = false;
  wire::SimClockMessage message;
  message.mutable_done()->set_cycle(cycle_);
  send(message);
}

void Conductor::wait_for_exit(ChildProcess& child) {
  const Patience patience(kExitPatience_ms);
  while (!child.exit_code()) {
    attend(5);
    if (patience.is_over()) lose(child, "left the clock but does not end");
  }
  attend(0);
}

void Conductor::send(const wire::SimClockMessage& message) {
  const std::string frame = wire::encode_frame(wire::FrameType::kSimClock, message.SerializeAsString());
  for (std::size_t sent = 0; sent < frame.size();) {
    const ssize_t n = ::send(clock_, frame.data() + sent, frame.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      is_clock_lost_ = true;
      return;  // attend() says which program is gone
    }
    sent += static_cast<std::size_t>(n);
  }
}

void Conductor::take_clock_messages() {
  std::array<char, 4096> bytes{};
  const ssize_t n = recv(clock_, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (n < 0) return;
  std::vector<std::string> payloads;
  if (n == 0 || !decoder_.feed({bytes.data(), static_cast<std::size_t>(n)}, payloads)) is_clock_lost_ = true;
  for (const std::string& payload : payloads) {
    wire::SimClockMessage message;
    if (!message.ParseFromString(payload)) continue;
    if (message.has_welcome()) {
      is_welcome_ = true;
      period_s_ = 1e-9 * static_cast<double>(message.welcome().period_ns());
      is_lockstep_ = message.welcome().pace() == wire::SIM_PACE_LOCKSTEP;
    } else if (message.has_grant()) {
      is_grant_pending_ = true;
      cycle_ = message.grant().cycle();
      participants_ = message.grant().participants();
    } else if (message.has_ok()) {
      is_answered_ = true;
      answer_error_ = message.ok().error();
    }
  }
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
