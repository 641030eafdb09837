// The program: bus, cycle, link and files put together, in lockstep with a simulation or at real pace.
#pragma once

#include <atomic>
#include <memory>

#include "arm_controller/control_loop.hpp"
#include "arm_controller/flags.hpp"
#include "arm_controller/link_server.hpp"
#include "arm_controller/machine_set_up.hpp"
#include "arm_controller/service_manager.hpp"
#include "protocol/descriptor.hpp"

namespace armsight::arm {

class Program {
 public:
  /// Reads files, joins clock and bus, listens. Throws ConfigError, BusError, std::runtime_error; moves nothing.
  explicit Program(const Flags& flags);
  ~Program();

  /// Until `leaves` is set (then the arm is stopped first) or the bus is lost. Answers the exit code.
  int run(const std::atomic<bool>& leaves);

 private:
  int run_lockstep(const std::atomic<bool>& leaves);
  int run_real(const std::atomic<bool>& leaves);
  void link_thread();
  /// For the thread of the cycle. Says what was not granted; false: that is too little for --require-rt.
  bool set_up_real_time();
  void cycle_thread(const std::atomic<bool>& leaves);
  bool is_done(const std::atomic<bool>& leaves, Time now);
  void say_goodbye();

  bool requires_real_time_;
  std::optional<int> cpu_;
  RobotConfig robot_;
  Descriptor state_folder_;
  StartModel start_;
  std::unique_ptr<net::Clock> clock_;
  std::unique_ptr<CanBus> bus_;
  Mailboxes mailboxes_;
  Tape tape_;
  LoopStatistics statistics_;
  std::unique_ptr<FileWriter> files_;
  std::unique_ptr<LinkServer> link_;
  std::unique_ptr<ControlLoop> loop_;
  ServiceManager service_manager_;
  std::optional<MachineSetUp> machine_;
  std::optional<Time> leave_by_;
  std::atomic<bool> cycle_ended_{false}, gives_up_{false};
  std::atomic<int> exit_code_{0};
};

}  // namespace armsight::arm
