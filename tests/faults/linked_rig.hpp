// The fault rig with the controller's link: hosts over loopback TCP, time handed in.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/arm_controller/link_rig.hpp"
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {

using arm::test::Peer;

class LinkedRig : public FaultRig {
 public:
  LinkedRig();
  ~LinkedRig() override;

  /// A peer that has said Hello.
  std::unique_ptr<Peer> connect(wire::Role role = wire::ROLE_COMMAND);
  /// ... holds the lease, keeps it (see `beating`), and has powered the arm.
  std::unique_ptr<Peer> powered_commander();
  std::optional<wire::Envelope> wait_for(Peer& peer, const std::function<bool(const wire::Envelope&)>& fits,
                                         int at_most = 1500);
  /// Refusal's reason; REFUSAL_REASON_UNSPECIFIED: it was accepted.
  wire::RefusalReason refusal_of(Peer& peer, std::uint64_t sequence);
  wire::Envelope hello(wire::Role role) const { return arm::test::hello_of(robot, role); }
  static wire::Envelope joint_goal(const JointVector& q_real_rad, double speed_scale = 1.0);
  wire::Envelope pose_goal(const JointVector& q_real_rad) const;

  /// The peers whose hosts are alive: a heartbeat every 50 ms.
  std::vector<Peer*> beating;
  arm::test::HandClock clock;
  std::unique_ptr<arm::LinkServer> link;
  /// The largest piece of memory that the link asked for at once, since the last call.
  std::size_t take_largest_allocation() { return std::exchange(largest_allocation_, 0); }

 protected:
  void before_cycle() override;
  void after_cycle() override;

 private:
  std::filesystem::path folder_;
  std::unique_ptr<arm::FileWriter> files_;
  std::size_t largest_allocation_ = 0;
  int cycle_ = 0;
};

}  // namespace armsight::faults
