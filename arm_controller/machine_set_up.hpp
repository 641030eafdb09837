// What of the machine stands in the way of a steady cycle: sleeping processors, a slow governor, interrupts on its CPU,
// the throttle of real-time threads, a kernel that does not preempt. Told, one sentence each with what to do; only the
// administrator can change it, so none of it is needed to run.
#pragma once

#include <filesystem>

#include "arm_controller/real_time.hpp"
#include "protocol/descriptor.hpp"

namespace armsight::arm {

class MachineSetUp {
 public:
  /// `root`: where /dev, /proc and /sys are looked for; `cpu`: where the cycle runs, if that was said.
  explicit MachineSetUp(std::optional<int> cpu, const std::filesystem::path& root = "/");

  const std::vector<NotGranted>& not_granted() const { return not_granted_; }

 private:
  void forbid_sleep();
  void look_at_cpu(std::optional<int> cpu);
  void look_at_interrupts(int cpu);
  void look_at_governor(std::optional<int> cpu);
  void look_at_throttle();
  void look_at_kernel();
  void add(const std::string& sentence) { not_granted_.push_back({sentence, false}); }

  std::filesystem::path root_;
  Descriptor latency_;  ///< processors stay awake while it is open
  std::vector<NotGranted> not_granted_;
};

/// "0-2,5" of the kernel's lists holds it.
bool is_in_cpu_list(const std::string& list, int cpu);

}  // namespace armsight::arm
