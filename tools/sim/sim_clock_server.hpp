// arm_sim owns the time (protocol/sim_clock.proto): who takes part, whose crystal runs how, and in lockstep when the
// next cycle begins.
//
//   Grant(k) ──► participants work ──► Done(k), all of them ──► arm_sim simulates [t_k, t_k+1) ──► Grant(k+1)
//
// Simulated time runs only while somebody takes part. A participant whose connection breaks is dropped; what it had
// sent in the cycle it never reported does not act. At real pace this only welcomes and takes the conductor's wishes.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "protocol/transport/monotonic_clock.hpp"
#include "tools/sim/server_clock.hpp"

namespace armsight::sim {

struct SimClockOptions {
  std::string path;
  bool is_lockstep = true;
  Duration period = std::chrono::milliseconds(4);
  std::uint64_t seed = 1;
};

class SimClockServer {
 public:
  /// The conductor's wishes; each returns why not, or an empty text.
  struct Wishes {
    std::function<std::string()> inject_drift;
    std::function<std::string(const std::string& truth_file)> finish;
  };

  SimClockServer(const SimClockOptions& options, Wishes wishes);
  ~SimClockServer();

  ServerClock& clock();
  /// Lockstep: grants the cycle that begins at clock().now() and returns when every participant is done with it; what
  /// they sent to arm_sim is then due in clock(). False: `is_stopping` said so, or the run is finished.
  bool run_participants(const std::function<bool()>& is_stopping);
  /// Lockstep: arm_sim has simulated the cycle; the clock stands at its end.
  void end_cycle();
  /// Real pace: never blocks.
  void serve();
  std::vector<int> descriptors() const;

  bool is_finished() const;
  std::size_t participants() const;
  /// How many have ever joined. From any thread.
  std::size_t ever_joined() const;
  std::uint64_t cycle() const;
  /// Simulated time → clock of a participant; 0 and unknown ones: simulated time itself. From any thread.
  std::int64_t to_own_ns(std::uint32_t participant, std::int64_t sim_time_ns) const;
  /// Of the latest controller, also when it has left.
  std::uint32_t last_arm_controller() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Simulated time begins here, so that no crystal shows a negative time.
inline constexpr std::int64_t kFirstTime_ns = 10'000'000'000;

/// Seeded: offset up to ±1 s, skew up to ±50 ppm; a conductor's shows simulated time itself.
net::Crystal make_crystal(std::uint64_t seed, std::uint32_t participant, bool is_conductor);
/// When messages sent by one participant to another at t_k arrive: 0.05 … 3 ms later, below a cycle, in order.
std::vector<Time> link_arrivals(std::uint64_t seed, std::uint32_t sender, std::uint32_t receiver, std::uint64_t first,
                                std::size_t count, Time cycle_start, Duration period);

}  // namespace armsight::sim
