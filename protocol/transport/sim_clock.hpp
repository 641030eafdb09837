// A participant of arm_sim's simulated clock (protocol/sim_clock.proto), at the pace that arm_sim announces.
#pragma once

#include "protocol/transport/clock.hpp"

namespace armsight::net {

/// What only the conductor of a run may do (the demo, the tests). Both throw ClockLost when arm_sim is gone and
/// std::runtime_error with arm_sim's reason when it refuses.
class SimConductor : public Clock {
 public:
  /// The drift of the noise set, from the end of this cycle on.
  virtual void inject_drift() = 0;
  /// Writes the truth of the run; the simulation is over.
  virtual void finish(const std::string& truth_file) = 0;
};

std::unique_ptr<SimConductor> join_as_conductor(const std::string& path, const std::string& name, Duration period);

}  // namespace armsight::net
