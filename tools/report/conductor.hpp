// Starts the programs of a run and paces them: a participant of arm_sim's clock that holds time still while a program
// starts or ends, so that a run does not depend on how fast the machine starts processes.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/framing.hpp"
#include "tools/report/child_process.hpp"

namespace armsight::wire {
class SimClockMessage;
}

namespace armsight::demo {

/// A program or the simulated clock is gone, or does not come up: exit code 3.
class ProgramLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
/// Ctrl-C.
class Interrupted : public std::exception {};

class Conductor {
 public:
  /// Where every line of every program is also written to; `is_verbose` shows them.
  Conductor(const std::filesystem::path& log_file, bool is_verbose);
  ~Conductor();

  /// Starts a server; returns when it has printed a line that begins with `ready_prefix`, and what stands behind it.
  std::string start_server(const std::string& name, const std::vector<std::string>& command,
                           const std::string& ready_prefix);
  /// Joins the clock that arm_sim serves at this path.
  void join_clock(const std::filesystem::path& path);
  /// Runs a program to its end, returns its exit code; `lines`: everything it printed.
  int run(const std::string& name, const std::vector<std::string>& command, std::vector<std::string>* lines = nullptr);
  /// Starts a program and returns once it takes part; for tests that do something to it meanwhile.
  ChildProcess& start(const std::string& name, const std::vector<std::string>& command);
  /// Lets so many cycles (at real pace: milliseconds × 4) go by, or fewer when a program in `ending` ends.
  void run_cycles(std::uint64_t cycles);
  /// Ends a program by its pid while time goes on.
  int end(const std::string& name);
  /// SIGKILL, for tests: the program gets no chance.
  void kill(const std::string& name);

  void inject_drift();
  /// The simulation is over; arm_sim writes the truth.
  void finish(const std::filesystem::path& truth_file);

  bool is_lockstep() const { return is_lockstep_; }
  /// Of arm_sim; from lockstep cycles or the machine's clock.
  double time_s() const;
  ChildProcess* find(const std::string& name);

  /// For the handler of SIGINT and SIGTERM.
  static volatile std::sig_atomic_t is_interrupted;

 private:
  void send(const wire::SimClockMessage& message);
  void take_clock_messages();
  void attend(int timeout_ms, bool must_servers_live = true);
  void hold();
  void release();
  void request(const wire::SimClockMessage& message, const std::string& what);
  void wait_for_exit(ChildProcess& child);
  [[noreturn]] void lose(ChildProcess& child, const std::string& what);

  std::vector<std::unique_ptr<ChildProcess>> children_;
  std::vector<std::string> servers_;
  std::FILE* log_ = nullptr;
  bool is_verbose_ = false;
  bool is_lockstep_ = false;
  bool is_clock_lost_ = false;
  int clock_ = -1;
  wire::FrameDecoder decoder_;
  std::uint64_t cycle_ = 0;
  double period_s_ = 0.0;
  bool is_grant_pending_ = false;
  bool is_welcome_ = false;
  bool is_answered_ = false;
  std::uint32_t participants_ = 0;
  std::string answer_error_;
};

}  // namespace armsight::demo
