#include "arm_controller/machine_set_up.hpp"

#include <fcntl.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

namespace armsight::arm {
namespace {

namespace fs = std::filesystem;

/// First line; empty: not there, or hidden from this service.
std::string line_of(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

}  // namespace

bool is_in_cpu_list(const std::string& list, int cpu) {
  std::istringstream ranges(list);
  for (std::string range; std::getline(ranges, range, ',');) {
    int first = 0, last = 0;
    const int read = std::sscanf(range.c_str(), "%d-%d", &first, &last);
    if (read >= 1 && cpu >= first && cpu <= (read == 2 ? last : first)) return true;
  }
  return false;
}

MachineSetUp::MachineSetUp(std::optional<int> cpu, const fs::path& root) : root_(root) {
  forbid_sleep();
  look_at_cpu(cpu);
  if (cpu) look_at_interrupts(*cpu);
  look_at_governor(cpu);
  look_at_throttle();
  look_at_kernel();
}

void MachineSetUp::forbid_sleep() {
  latency_ = Descriptor(::open((root_ / "dev/cpu_dma_latency").c_str(), O_WRONLY | O_CLOEXEC));
  const std::int32_t longest_us = 0;
  if (latency_.get() >= 0 && ::write(latency_.get(), &longest_us, sizeof longest_us) == sizeof longest_us) return;
  const int error = errno;
  if (error == ENOENT && !fs::exists(root_ / "sys/devices/system/cpu/cpuidle")) return;  // they never sleep
  add(std::string("idle processors may sleep deeply (/dev/cpu_dma_latency: ") + std::strerror(error) +
      "): let it be written, as the package's udev rule does for the group armsight");
}

void MachineSetUp::look_at_cpu(std::optional<int> cpu) {
  const std::string isolated = line_of(root_ / "sys/devices/system/cpu/isolated");
  if (!cpu && isolated.empty())
    add("the cycle shares its CPU with everything else: boot with isolcpus=N irqaffinity=0, start with --cpu N");
  else if (!cpu)
    add("the cycle does not use the isolated CPU: start with --cpu " + isolated.substr(0, isolated.find_first_of(",-")));
  else if (!is_in_cpu_list(isolated, *cpu))
    add("CPU " + std::to_string(*cpu) + " is shared with other programs: boot with isolcpus=" + std::to_string(*cpu));
}

void MachineSetUp::look_at_interrupts(int cpu) {
  std::error_code error;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(root_ / "proc/irq", error))
    if (is_in_cpu_list(line_of(entry.path() / "smp_affinity_list"), cpu)) ++count;
  if (count > 0)
    add(std::to_string(count) + " interrupts may run on CPU " + std::to_string(cpu) +
        ": boot with irqaffinity= naming the others, stop irqbalance");
}

void MachineSetUp::look_at_governor(std::optional<int> cpu) {
  const fs::path folder = root_ / "sys/devices/system/cpu" / ("cpu" + std::to_string(cpu.value_or(0))) / "cpufreq";
  const std::string governor = line_of(folder / "scaling_governor");
  if (!governor.empty() && governor != "performance")
    add("the processor's speed follows the governor '" + governor + "': cpupower frequency-set -g performance");
}

// The usual 95 % cannot meet a cycle that takes a few, and saves the machine from one that never ends.
void MachineSetUp::look_at_throttle() {
  const std::string runtime = line_of(root_ / "proc/sys/kernel/sched_rt_runtime_us");
  const std::string period = line_of(root_ / "proc/sys/kernel/sched_rt_period_us");
  if (runtime.empty() || period.empty() || runtime == "-1") return;
  if (std::strtod(runtime.c_str(), nullptr) < 0.5 * std::strtod(period.c_str(), nullptr))
    add("real-time threads get " + runtime + " of " + period + " us only: sysctl kernel.sched_rt_runtime_us=950000");
}

void MachineSetUp::look_at_kernel() {
  const std::string version = line_of(root_ / "proc/version");
  const bool is_real_time = line_of(root_ / "sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != version.npos;
  if (!is_real_time)
    add("the kernel is not built with PREEMPT_RT: worst wake-ups are its drivers' to decide; install linux-image-rt");
}

}  // namespace armsight::arm
