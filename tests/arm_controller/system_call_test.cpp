// The tick makes no system call at all, the cycle none but those of its bus and its sleep: the kernel kills a child
// that makes another. A clock that is read by a system call (a machine without vDSO) makes these tests skip.
#include <gtest/gtest.h>

#include <csignal>
#include <memory>

#include "protocol/transport/wait.hpp"
#include "tests/arm_controller/child.hpp"
#include "tests/arm_controller/only_calls.hpp"
#include "tests/arm_controller/socket_rig.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace armsight::arm::test {
namespace {

constexpr int kDone = 0, kOrdersNotDone = 1, kNoFilter = 2;

class SystemCalls : public testing::Test {
 protected:
  void SetUp() override {
    const ChildEnd clock = run_in_child([] {
      if (!allow_only({})) return kNoFilter;
      return net::monotonic_ns() > 0 ? kDone : kOrdersNotDone;
    });
    if (clock.exit_code == kNoFilter) GTEST_SKIP() << "this kernel has no seccomp filters";
    if (clock.signal == SIGSYS) GTEST_SKIP() << "this machine's clock is read by a system call";
    ASSERT_EQ(clock.exit_code, kDone);
  }
};

int run_ticks() {
  const RobotConfig robot = nominal_robot();
  Controller controller(robot, nominal_start(robot));
  JointSamples joints;
  joints.q_rad = JointVector::Constant(5, 0.1);
  joints.torque_Nm = JointVector::Zero(5);
  joints.has_positions = joints.is_fresh = true;
  joints.phase = BusPhase::kPowered;
  const auto inbox = std::make_unique<TickInbox>();
  BusyOutcome outcome;
  Time now = time_from_ns(1'000'000'000);
  if (!allow_only({})) return kNoFilter;
  for (int i = 0; i < kBusyCycles; ++i) {
    joints.time = now += std::chrono::milliseconds(4);
    fill(*inbox, i, now, robot, joints.q_rad);
    const TickOutput& output = controller.tick(now, joints, *inbox);
    for (std::size_t k = 0; k < output.event_count; ++k) outcome.count(output.events[k]);
    if (controller.mode() == Mode::kServo || controller.mode() == Mode::kHold) joints.q_rad = output.command.q_rad;
  }
  ::_exit(outcome.is_complete() ? kDone : kOrdersNotDone);  // destructors may call the system
}

int run_cycles() {
  SocketRig rig;
  if (!allow_only({SYS_recvfrom, SYS_sendto, SYS_clock_nanosleep})) ::_exit(kNoFilter);
  ::_exit(rig.work([] {}, [] {}) ? kDone : kOrdersNotDone);
}

TEST_F(SystemCalls, TheFilterKillsWhoMakesAnother) {
  const ChildEnd end = run_in_child([] { return allow_only({}) ? static_cast<int>(::getppid()) : kNoFilter; });
  EXPECT_EQ(end.signal, SIGSYS);
}

TEST_F(SystemCalls, TheTickMakesNone) {
  const ChildEnd end = run_in_child(run_ticks);
  EXPECT_EQ(end.signal, 0) << (end.signal == SIGSYS ? "a tick called the system" : "");
  EXPECT_EQ(end.exit_code, kDone);
}

TEST_F(SystemCalls, TheCycleMakesThoseOfItsBusAndItsSleepOnly) {
  const ChildEnd end = run_in_child(run_cycles);
  EXPECT_EQ(end.signal, 0) << (end.signal == SIGSYS ? "the cycle made another" : "");
  EXPECT_EQ(end.exit_code, kDone);
}

}  // namespace
}  // namespace armsight::arm::test

#endif
