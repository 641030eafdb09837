// The cycle as the program runs it, on an emulated bus that is a real socket, with scripted drives behind it in a
// thread of their own; time is handed in, so that a busy machine changes nothing. For tests that watch what the cycle's
// thread does.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "arm_controller/control_loop.hpp"
#include "protocol/descriptor.hpp"
#include "protocol/transport/wait.hpp"
#include "tests/arm_controller/arm_rig.hpp"
#include "tests/arm_controller/busy_work.hpp"
#include "tests/protocol/hand_clock.hpp"

namespace armsight::arm::test {

/// Sleeps as the real one does, once a cycle at least, until the drives have answered the last one. Frames that are
/// stamped with sync_ns (of the machine's clock) were on the bus when the last cycle began, however long that took.
class AnsweredClock final : public net::test::HandClock {
 public:
  Time now() const override { return time + Duration{net::monotonic_ns() - begin_ns_}; }
  Time wait_next_cycle() override;
  std::int64_t sync_ns() const { return begin_ns_ - kPeriod.count(); }
  std::atomic<std::uint64_t> asked{0}, answered{0};

 private:
  static constexpr Duration kPeriod = std::chrono::milliseconds(4);
  std::atomic<std::int64_t> begin_ns_{0};
};

class SocketRig {
 public:
  SocketRig();
  ~SocketRig();
  SocketRig(const SocketRig&) = delete;
  SocketRig& operator=(const SocketRig&) = delete;

  /// Brings the arm up and gives it busy_work; `before` and `after` stand around waiting and cycle. True: all orders
  /// came to their end. Itself neither allocates nor calls the system.
  template <typename Before, typename After>
  bool work(Before&& before, After&& after) {
    BusyOutcome outcome;
    int busy = 0;
    for (int i = 0; i < kMostCycles && busy < kBusyCycles; ++i) {
      if (state_.mode != Mode::kBoot && (busy > 0 || state_.mode == Mode::kReady)) order(busy++);
      before();
      loop_->cycle(clock_.wait_next_cycle(), 0);
      after();
      take(outcome);
    }
    return outcome.is_complete() && state_.mode == Mode::kHold;
  }

 private:
  static constexpr int kMostCycles = 4000;

  void order(int busy);
  void take(BusyOutcome& outcome);
  void serve();

  RobotConfig robot_ = nominal_robot();
  std::filesystem::path path_;
  AnsweredClock clock_;
  Descriptor listener_, hub_;
  std::unique_ptr<CanBus> bus_;
  const std::unique_ptr<Mailboxes> mailboxes_ = std::make_unique<Mailboxes>();
  const std::unique_ptr<Tape> tape_ = std::make_unique<Tape>();
  const std::unique_ptr<LoopStatistics> statistics_ = std::make_unique<LoopStatistics>();
  std::unique_ptr<ControlLoop> loop_;
  ArmSnapshot state_;
  TickInbox inbox_;
  Event event_;
  TickRecord record_;
  OrdersRecord orders_;
  std::atomic<bool> leaves_{false};
  std::thread drives_;
};

}  // namespace armsight::arm::test
