// What start-up says of the real time that was not granted, and which of it --require-rt refuses.
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "arm_controller/machine_set_up.hpp"
#include "tests/arm_controller/child.hpp"

namespace armsight::arm::test {
namespace {

namespace fs = std::filesystem;

/// A machine's /dev, /proc and /sys as files of a test: by default one where nothing is missing.
class Machine : public testing::Test {
 protected:
  void SetUp() override {
    write("dev/cpu_dma_latency", "");
    write("sys/devices/system/cpu/isolated", "2-3");
    write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "performance");
    write("sys/kernel/realtime", "1");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000");
    write("proc/sys/kernel/sched_rt_period_us", "1000000");
    write("proc/irq/24/smp_affinity_list", "0");
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  std::vector<NotGranted> look(std::optional<int> cpu = 3) { return MachineSetUp(cpu, root_).not_granted(); }
  void expect_told(const std::string& words, std::optional<int> cpu = 3) {
    const std::vector<NotGranted> told = look(cpu);
    ASSERT_EQ(told.size(), 1u) << words;
    EXPECT_NE(told[0].sentence.find(words), std::string::npos) << told[0].sentence;
    EXPECT_FALSE(told[0].is_needed);
  }
  fs::path root_ = fs::path(testing::TempDir()) / ("armsight-machine-" + std::to_string(::getpid()));
};

TEST_F(Machine, SaysNothingWhereNothingIsMissing) {
  EXPECT_TRUE(look().empty()) << look()[0].sentence;
  std::ifstream latency(root_ / "dev/cpu_dma_latency");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(latency), {}), std::string(4, '\0'));
}

TEST_F(Machine, TellsEachThingThatIsMissing) {
  expect_told("start with --cpu 2", std::nullopt);
  expect_told("boot with isolcpus=1", 1);
  write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "powersave");
  expect_told("governor 'powersave': cpupower");
  SetUp();
  write("sys/kernel/realtime", "0");
  write("proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC");
  expect_told("not built with PREEMPT_RT");
  write("proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_RT");
  write("proc/sys/kernel/sched_rt_runtime_us", "40000");
  expect_told("40000 of 1000000 us");
  write("proc/sys/kernel/sched_rt_runtime_us", "-1");
  write("proc/irq/25/smp_affinity_list", "0,3");
  expect_told("1 interrupts may run on CPU 3");
  fs::remove(root_ / "proc/irq/25/smp_affinity_list");
  fs::remove(root_ / "dev/cpu_dma_latency");
  EXPECT_TRUE(look().empty()) << "a kernel without idle states needs no such device";
  fs::create_directories(root_ / "sys/devices/system/cpu/cpuidle");
  expect_told("cpu_dma_latency: No such file");
}

bool set_up_fails_without_rights(std::optional<int> cpu, std::size_t needed) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct none[2] = {};
  const rlimit no_priority{0, 0}, one_page{4096, 4096};
  if (::setrlimit(RLIMIT_RTPRIO, &no_priority) != 0 || ::setrlimit(RLIMIT_MEMLOCK, &one_page) != 0) return false;
  if (::syscall(SYS_capset, &header, none) != 0) return false;
  std::vector<NotGranted> failed = lock_memory();
  for (const NotGranted& item : become_real_time(cpu)) failed.push_back(item);
  for (const NotGranted& item : failed)
    if (!item.is_needed) return false;
  return failed.size() == needed;
}

TEST(RealTime, WithoutRightsMemoryAndPriorityAreTold) {
  EXPECT_EQ(run_in_child([] { return set_up_fails_without_rights(std::nullopt, 2) ? 0 : 1; }).exit_code, 0);
}

TEST(RealTime, ACpuThatIsNotThereIsTold) {
  EXPECT_EQ(run_in_child([] { return set_up_fails_without_rights(1000, 3) ? 0 : 1; }).exit_code, 0);
}

TEST(RealTime, TheThreadStandsOnItsCpuAlone) {
  EXPECT_EQ(run_in_child([] {
              cpu_set_t allowed;
              sched_getaffinity(0, sizeof allowed, &allowed);
              int cpu = 0;
              while (!CPU_ISSET(static_cast<std::size_t>(cpu), &allowed)) ++cpu;
              become_real_time(cpu);
              sched_getaffinity(0, sizeof allowed, &allowed);
              return CPU_COUNT(&allowed) == 1 && CPU_ISSET(static_cast<std::size_t>(cpu), &allowed) ? 0 : 1;
            }).exit_code,
            0);
}

}  // namespace
}  // namespace armsight::arm::test
