// Row 15: many cycles in a row, always moving. Every SYNC is on the bus, the cycle asks for no memory, the process
// does not grow. Twenty thousand cycles here; a million, and a run on the machine's own clock, by tools/test --soak.
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>

#include "arm_controller/real_time.hpp"
#include "protocol/transport/monotonic_clock.hpp"
#include "tests/arm_controller/watch.hpp"
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

bool is_soak() { return std::getenv("ARMSIGHT_SOAK") != nullptr; }

/// Between cycle and bus model, so that the model's own memory is not the cycle's.
class CountedBus final : public arm::CanBus {
 public:
  explicit CountedBus(arm::CanBus& bus) : bus_(bus) {}
  void pump_in() {
    next_in_ = received_ = 0;
    while (received_ < in_.size() && bus_.receive(in_[received_])) ++received_;
  }
  void pump_out() {
    for (std::size_t i = 0; i < sent_; ++i) bus_.send(out_[i]);
    sent_ = 0;
  }
  arm::SendResult send(const CanFrame& frame) noexcept override {
    if (sent_ == out_.size()) return arm::SendResult::kQueueFull;
    out_[sent_++] = frame;
    return arm::SendResult::kSent;
  }
  bool receive(arm::BusFrame& frame) noexcept override {
    if (next_in_ == received_) return false;
    frame = in_[next_in_++];
    return true;
  }
  arm::BusErrors take_errors() noexcept override { return bus_.take_errors(); }
  const std::string& name() const override { return bus_.name(); }

 private:
  arm::CanBus& bus_;
  std::array<CanFrame, 64> out_{};
  std::array<arm::BusFrame, 128> in_{};
  std::size_t sent_ = 0, received_ = 0, next_in_ = 0;
};

class LongRig : public FaultRig {
 public:
  LongRig() { start_controller(); }

  std::size_t allocations = 0;
  std::uint64_t syncs = 0, gaps = 0;

  void run(std::uint64_t cycles, const std::function<void()>& wait = {}) {
    for (std::uint64_t i = 0; i < cycles; ++i) {
      if (i % 900 == 0) send_goal(i / 900 % 2 == 0 ? far_goal() : posture(-0.8, -0.5, 0.7, 0.6, -0.9));
      if (wait) wait();
      cycle();
      if (i % 500 == 499) take_log();
    }
    take_log();
  }

 protected:
  arm::CanBus& controllers_bus() override {
    counted_.emplace(*bus_end);
    return *counted_;
  }
  void before_cycle() override {
    if (!counted_) return;
    counted_->pump_in();
    arm::test::begin_watch();
  }
  void after_cycle() override {
    allocations += arm::test::end_watch().allocations;
    if (counted_) counted_->pump_out();
    FaultRig::after_cycle();
  }

 private:
  void take_log() {
    for (const BusLine& line : log) {
      const auto sync = decode_sync(line.frame);
      if (!sync) continue;
      ++syncs;
      if (last_counter_ && sync->counter != *last_counter_ % 10 + 1) ++gaps;
      last_counter_ = sync->counter;
    }
    log.clear();
    truth.clear();
    events.clear();
    world->forget_trace();
  }
  std::optional<CountedBus> counted_;
  std::optional<std::uint8_t> last_counter_;
};

long resident_kib() {
  std::ifstream statm("/proc/self/statm");
  long pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * sysconf(_SC_PAGESIZE) / 1024;
}

TEST(LongRun, MissesNoSyncAsksForNoMemoryAndDoesNotGrow) {
  const std::uint64_t cycles = is_soak() ? 1'000'000 : 20'000;
  LongRig rig;
  ASSERT_TRUE(rig.power_up());
  rig.run(2000);
  rig.syncs = rig.gaps = rig.allocations = 0;
  const long before = resident_kib();
  rig.run(cycles);
  EXPECT_EQ(rig.syncs, cycles);
  EXPECT_EQ(rig.gaps, 0U);
  EXPECT_EQ(rig.allocations, 0U) << (arm::test::can_watch() ? "" : "(not watched under a sanitizer)");
  EXPECT_LT(resident_kib() - before, 1024) << "KiB";
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

TEST(LongRun, KeepsItsRateOnTheMachinesClock) {
  if (!is_soak()) GTEST_SKIP() << "by tools/test --soak only";
  std::vector<arm::NotGranted> denied = arm::lock_memory();
  for (const arm::NotGranted& item : arm::become_real_time(std::nullopt)) denied.push_back(item);
  if (!denied.empty()) GTEST_SKIP() << "not run: " << denied.front().sentence;
  LongRig rig;
  ASSERT_TRUE(rig.power_up());
  const auto clock = net::make_monotonic_clock(rig.period());
  std::vector<Duration> late;
  late.reserve(1'000'000);
  Time due = clock->now() + 2 * rig.period();
  rig.run(1'000'000, [&] {
    timespec at{to_ns(due) / 1'000'000'000, to_ns(due) % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    late.push_back(clock->now() - due);
    due += rig.period();
  });
  std::ranges::sort(late);
  EXPECT_LT(late[late.size() * 999 / 1000], std::chrono::microseconds(150)) << "99.9 % of the wake-ups";
  EXPECT_EQ(rig.gaps, 0U);
}

}  // namespace
}  // namespace armsight::faults
