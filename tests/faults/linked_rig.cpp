#include "tests/faults/linked_rig.hpp"

#include <stdlib.h>

#include "shared/kinematics.hpp"
#include "tests/arm_controller/watch.hpp"

namespace armsight::faults {
namespace {

constexpr int kBeat = 12;  ///< cycles

wire::Envelope beat() {
  wire::Envelope envelope;
  envelope.mutable_heartbeat();
  return envelope;
}

std::filesystem::path new_folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "faults_XXXXXX").string();
  return ::mkdtemp(pattern.data());
}

}  // namespace

LinkedRig::LinkedRig() : folder_(new_folder()) {
  has_commander = false;
  clock.time = now;
  files_ = std::make_unique<arm::FileWriter>(folder_, robot, "emulated", "", tape);
  files_->begin(now);
  link = std::make_unique<arm::LinkServer>("127.0.0.1:0", robot, "emulated", mailboxes, statistics, *files_, clock);
}

LinkedRig::~LinkedRig() {
  link.reset();
  files_.reset();
  std::filesystem::remove_all(folder_);
}

void LinkedRig::before_cycle() {
  clock.time = now;
  if (cycle_++ % kBeat == 0)
    for (Peer* peer : beating) peer->send(beat());
  arm::test::begin_watch();
  link->step(now);
  largest_allocation_ = std::max(largest_allocation_, arm::test::end_watch().largest_bytes);
}

void LinkedRig::after_cycle() {
  if (const auto newest = mailboxes.state.take(); newest && loop) {
    state = *newest;
    mailboxes.state.put(*newest);  // it is the link's to take
  }
  judge_set_point();
  files_->wait_idle();
  link->publish(now);
}

std::optional<wire::Envelope> LinkedRig::wait_for(Peer& peer, const std::function<bool(const wire::Envelope&)>& fits,
                                                  int at_most) {
  for (int i = 0; i < at_most; ++i) {
    cycle();
    for (const wire::Envelope& envelope : peer.take())
      if (fits(envelope)) return envelope;
  }
  return std::nullopt;
}

wire::RefusalReason LinkedRig::refusal_of(Peer& peer, std::uint64_t sequence) {
  const auto answer =
      wait_for(peer, [sequence](const wire::Envelope& e) { return arm::test::is_answer_to(sequence, e); }, 100);
  EXPECT_TRUE(answer) << "no answer to " << sequence;
  return answer ? answer->refusal().reason() : wire::REFUSAL_REASON_UNSPECIFIED;
}

std::unique_ptr<Peer> LinkedRig::connect(wire::Role role) {
  auto peer = std::make_unique<Peer>(link->port(), clock);
  peer->send(hello(role));
  EXPECT_TRUE(wait_for(*peer, [](const auto& e) { return e.has_hello_reply(); }, 50));
  return peer;
}

std::unique_ptr<Peer> LinkedRig::powered_commander() {
  auto peer = connect();
  wire::Envelope lease, hold;
  lease.mutable_lease_request();
  hold.mutable_mode_request()->set_mode(wire::MODE_HOLD);
  beating.push_back(peer.get());
  EXPECT_EQ(refusal_of(*peer, peer->send(lease)), wire::REFUSAL_REASON_UNSPECIFIED);
  EXPECT_TRUE(cycle_until([this] { return is_configured(); }, 2000));
  cycles(2);
  peer->take();
  EXPECT_EQ(refusal_of(*peer, peer->send(hold)), wire::REFUSAL_REASON_UNSPECIFIED);
  EXPECT_TRUE(cycle_until([this] { return all_drives(DriveState::kOperationEnabled); }, 500));
  cycles(20);
  return peer;
}

wire::Envelope LinkedRig::joint_goal(const JointVector& q_real_rad, double speed_scale) {
  wire::Envelope envelope;
  wire::JointGoal& goal = *envelope.mutable_joint_goal();
  goal.set_goal(1);
  for (const double q : q_real_rad) goal.add_q_real_rad(q);
  goal.set_speed_scale(speed_scale);
  goal.set_valid_for_ns(100'000'000);
  return envelope;
}

wire::Envelope LinkedRig::pose_goal(const JointVector& q_real_rad) const {
  wire::Envelope envelope;
  wire::PoseGoal& goal = *envelope.mutable_pose_goal();
  goal.set_goal(2);
  goal.set_frame(wire::GOAL_FRAME_BASE);
  to_wire(forward_kinematics(robot.arm.chain, q_real_rad), goal.mutable_hand_goal());
  goal.set_position_tolerance_m(1e-3);
  goal.set_orientation_tolerance_rad(0.02);
  goal.set_speed_scale(1.0);
  goal.set_valid_for_ns(100'000'000);
  return envelope;
}

}  // namespace armsight::faults
