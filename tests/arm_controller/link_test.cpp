// The link: who may do what, what is refused and why, and that no message ends the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"
#include "tests/arm_controller/link_rig.hpp"

namespace armsight::arm::test {
namespace {

wire::Envelope joint_goal(std::uint64_t id, double q1, double speed_scale = 1.0) {
  wire::Envelope envelope;
  wire::JointGoal& goal = *envelope.mutable_joint_goal();
  goal.set_goal(id);
  for (const double q : {q1, 0.1, -0.3, 1.0, 0.2}) goal.add_q_real_rad(q);
  goal.set_speed_scale(speed_scale);
  goal.set_valid_for_ns(100'000'000);
  return envelope;
}

wire::Envelope pose_goal(const LinkRig& rig, const JointVector& q) {
  wire::Envelope envelope;
  wire::PoseGoal& goal = *envelope.mutable_pose_goal();
  goal.set_goal(5);
  goal.set_frame(wire::GOAL_FRAME_BASE);
  to_wire(forward_kinematics(rig.robot.arm.chain, q), goal.mutable_hand_goal());
  goal.set_position_tolerance_m(1e-3);
  goal.set_orientation_tolerance_rad(0.02);
  goal.set_speed_scale(1.0);
  goal.set_valid_for_ns(100'000'000);
  return envelope;
}

TEST(Link, ShakesHandsAndTellsModelAndState) {
  LinkRig rig;
  Peer peer(rig.link->port(), rig.clock);
  rig.cycles(3);
  peer.send(rig.hello(wire::ROLE_OBSERVE));
  const auto reply = rig.wait_for(peer, [](const auto& e) { return e.has_hello_reply(); });
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->hello_reply().joint_count(), 5u);
  EXPECT_EQ(reply->hello_reply().lease_ns(), 200'000'000);
  EXPECT_TRUE(
      rig.wait_for(peer, [](const auto& e) { return e.has_arm_state() && e.arm_state().q_reading_rad_size() == 5; }));
}

TEST(Link, TellsItsModeBeforeTheJointsAreKnownAndWhyTheyAreNot) {
  LinkRig rig;
  rig.bus.drive(2).is_silent = true;
  Peer peer(rig.link->port(), rig.clock);
  peer.send(rig.hello(wire::ROLE_OBSERVE));
  const auto first = rig.wait_for(peer, [](const auto& e) { return e.has_arm_state(); });
  ASSERT_TRUE(first);
  EXPECT_EQ(first->arm_state().q_reading_rad_size(), 0) << "an angle that nobody measured";
  EXPECT_EQ(first->arm_state().q_command_rad_size(), 0);
  const auto fault = rig.wait_for(
      peer, [](const auto& e) { return e.has_arm_state() && e.arm_state().mode() == wire::MODE_FAULT; });
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->arm_state().fault_code(), static_cast<std::uint32_t>(FaultCode::kNodeAbsent));
}

TEST(Link, AnswersHeartbeatsWithTheFourStamps) {
  LinkRig rig;
  auto peer = rig.commander();
  wire::Envelope beat;
  beat.mutable_heartbeat()->set_host_send_time_ns(123);
  peer->send(beat);
  const auto reply = rig.wait_for(*peer, [](const auto& e) {
    return e.has_heartbeat_reply() && e.heartbeat_reply().host_send_time_ns() == 123;
  });
  ASSERT_TRUE(reply);
  EXPECT_GE(reply->heartbeat_reply().arm_send_time_ns(), reply->heartbeat_reply().arm_receive_time_ns());
  EXPECT_GT(reply->heartbeat_reply().arm_receive_time_ns(), 0);
}

TEST(Link, BringsAJointGoalToItsEnd) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  EXPECT_TRUE(rig.answer_to(*peer, peer->send(joint_goal(7, 0.4))).has_accepted());
  const auto status = rig.wait_for(*peer, [](const auto& e) {
    return e.has_goal_status() && e.goal_status().state() == wire::GOAL_STATE_ARRIVED;
  });
  ASSERT_TRUE(status);
  EXPECT_EQ(status->goal_status().goal(), 7u);
  EXPECT_NEAR(status->goal_status().q_reading_rad(0), 0.4, 5e-4);
}

TEST(Link, BringsAPoseGoalToItsEnd) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  JointVector q(5);
  q << 0.5, 0.2, -0.5, 1.2, 0.3;
  EXPECT_TRUE(rig.answer_to(*peer, peer->send(pose_goal(rig, q))).has_accepted());
  const auto status = rig.wait_for(*peer, [](const auto& e) {
    return e.has_goal_status() && e.goal_status().state() == wire::GOAL_STATE_ARRIVED;
  });
  ASSERT_TRUE(status);
  EXPECT_LT(status->goal_status().position_error_m(), 1e-3);
}

TEST(Link, APoseGoalKeepsToItsShareOfTheSpeed) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  JointVector q(5);
  q << 0.5, 0.2, -0.5, 1.2, 0.3;
  wire::Envelope slow = pose_goal(rig, q);
  slow.mutable_pose_goal()->set_speed_scale(0.2);
  ASSERT_TRUE(rig.answer_to(*peer, peer->send(slow)).has_accepted());
  double fastest = 0.0;
  const auto arrived = rig.wait_for(*peer, [&fastest](const auto& e) {
    for (const double speed : e.arm_state().speed_rad_s()) fastest = std::max(fastest, std::abs(speed));
    return e.has_goal_status() && e.goal_status().state() == wire::GOAL_STATE_ARRIVED;
  }, 6000);
  ASSERT_TRUE(arrived);
  EXPECT_LT(fastest, 0.2 * rig.robot.arm.limits.max_speed_rad_s.maxCoeff() * 1.1);
  EXPECT_GT(fastest, 0.5 * 0.2 * rig.robot.arm.limits.max_speed_rad_s.maxCoeff());
}

TEST(Link, RefusesAnotherProtocolAndNamesBothVersions) {
  LinkRig rig;
  Peer peer(rig.link->port(), rig.clock);
  wire::Envelope envelope = rig.hello(wire::ROLE_COMMAND);
  envelope.set_protocol_version(203);
  envelope.set_sequence(1);
  peer.send_raw(envelope.SerializeAsString());
  const auto refusal = rig.wait_for(peer, [](const auto& e) { return e.has_refusal(); });
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->refusal().reason(), wire::REFUSAL_REASON_VERSION);
  EXPECT_NE(refusal->refusal().text().find("2.3"), std::string::npos);
  EXPECT_NE(refusal->refusal().text().find("1.0"), std::string::npos);
}

TEST(Link, RefusesAHostWithAnotherArm) {
  LinkRig rig;
  Peer peer(rig.link->port(), rig.clock);
  wire::Envelope envelope = rig.hello(wire::ROLE_COMMAND);
  envelope.mutable_hello()->set_model_hash(1);
  EXPECT_EQ(rig.refusal_of(peer, peer.send(envelope)), wire::REFUSAL_REASON_MODEL_HASH);
}

TEST(Link, TakesCommandsFromTheLeasesHolderOnly) {
  LinkRig rig;
  auto first = rig.commander();
  Peer second(rig.link->port(), rig.clock);
  second.send(rig.hello(wire::ROLE_COMMAND));
  ASSERT_TRUE(rig.wait_for(second, [](const auto& e) { return e.has_hello_reply(); }, 20));
  EXPECT_EQ(rig.refusal_of(second, second.send(joint_goal(1, 0.4))), wire::REFUSAL_REASON_NO_LEASE);
  wire::Envelope lease;
  lease.mutable_lease_request();
  wire::Envelope beat;
  beat.mutable_heartbeat();
  first->send(beat);
  EXPECT_EQ(rig.refusal_of(second, second.send(lease)), wire::REFUSAL_REASON_LEASE_TAKEN);
  wire::Envelope stop;
  stop.mutable_stop();
  EXPECT_TRUE(rig.answer_to(second, second.send(stop)).has_accepted());
}

TEST(Link, TakesStopEvenBeforeHello) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->send(joint_goal(1, 1.2));
  rig.cycles(40);
  Peer stranger(rig.link->port(), rig.clock);
  wire::Envelope stop;
  stop.mutable_stop();
  stranger.send(stop);
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) {
    return e.has_goal_status() && e.goal_status().state() == wire::GOAL_STATE_STOPPED;
  }, 20));
}

TEST(Link, RefusesGoalsWithTheirReasons) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  const auto reason = [&](wire::Envelope e) { return rig.refusal_of(*peer, peer->send(std::move(e))); };
  EXPECT_EQ(reason(joint_goal(1, std::nan(""))), wire::REFUSAL_REASON_NOT_FINITE);
  EXPECT_EQ(reason(joint_goal(1, 1.6)), wire::REFUSAL_REASON_OUT_OF_LIMITS);
  EXPECT_EQ(reason(joint_goal(1, 0.4, std::nan(""))), wire::REFUSAL_REASON_NOT_FINITE);
  EXPECT_EQ(reason(joint_goal(1, 0.4, 0.0)), wire::REFUSAL_REASON_OUT_OF_LIMITS);
  wire::Envelope short_goal = joint_goal(1, 0.4);
  short_goal.mutable_joint_goal()->mutable_q_real_rad()->RemoveLast();
  EXPECT_EQ(reason(short_goal), wire::REFUSAL_REASON_MALFORMED);
  wire::Envelope stale = pose_goal(rig, JointVector::Constant(5, 0.3));
  stale.mutable_pose_goal()->set_model_revision(9);
  EXPECT_EQ(reason(stale), wire::REFUSAL_REASON_STALE_MODEL);
  wire::Envelope far = pose_goal(rig, JointVector::Constant(5, 0.3));
  far.mutable_pose_goal()->mutable_hand_goal()->set_x_m(0.9);
  EXPECT_EQ(reason(far), wire::REFUSAL_REASON_UNREACHABLE);
  wire::Envelope crooked = pose_goal(rig, JointVector::Constant(5, 0.3));
  crooked.mutable_pose_goal()->mutable_hand_goal()->set_qw(3.0);
  EXPECT_EQ(reason(crooked), wire::REFUSAL_REASON_BAD_QUATERNION);
  EXPECT_TRUE(peer->is_open());
}

// Inverse kinematics takes milliseconds on the link's thread: one goal a step, the newest, and everything else first.
TEST(Link, AFloodOfPoseGoalsIsJudgedOnceAndBehindEverythingElse) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  rig.cycles(2);
  peer->take();
  wire::Envelope far = pose_goal(rig, JointVector::Constant(5, 0.3));
  far.mutable_pose_goal()->mutable_hand_goal()->set_x_m(0.3);
  for (int i = 0; i < 20; ++i) peer->send(far);
  wire::Envelope beat;
  beat.mutable_heartbeat();
  peer->send(beat);
  std::vector<wire::Envelope> answers;
  for (int i = 0; i < 5; ++i) {
    rig.cycle();
    for (const wire::Envelope& e : peer->take())
      if (e.has_refusal() || e.has_heartbeat_reply()) answers.push_back(e);
  }
  ASSERT_EQ(answers.size(), 21u);
  for (std::size_t i = 0; i < 19; ++i) EXPECT_EQ(answers[i].refusal().reason(), wire::REFUSAL_REASON_OVERFLOW);
  EXPECT_TRUE(answers[19].has_heartbeat_reply());
  EXPECT_EQ(answers[20].refusal().reason(), wire::REFUSAL_REASON_UNREACHABLE);
}

TEST(Link, AStopBehindAPoseGoalWins) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  JointVector q(5);
  q << 0.5, 0.2, -0.5, 1.2, 0.3;
  const std::uint64_t goal = peer->send(pose_goal(rig, q));
  wire::Envelope stop;
  stop.mutable_stop();
  peer->send(stop);
  EXPECT_EQ(rig.refusal_of(*peer, goal), wire::REFUSAL_REASON_WRONG_STATE);
  rig.cycles(10);
  EXPECT_EQ(rig.link->mode(), Mode::kHold);
}

TEST(Link, TellsWhoeverIsReplacedBeforeTheNextCycle) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  wire::Envelope start;
  start.mutable_recalibration_start();
  const std::uint64_t first = peer->send(start), second = peer->send(start);
  bool is_told = false;
  EXPECT_TRUE(rig.wait_for(*peer, [&](const wire::Envelope& e) {
    const bool is_first = e.refusal().refused_sequence() == first;
    is_told = is_told || (is_first && e.refusal().reason() == wire::REFUSAL_REASON_OVERFLOW);
    return e.accepted().accepted_sequence() == second;
  }, 20));
  EXPECT_TRUE(is_told);
}

TEST(Link, RefusesWhatIsTooOld) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->clock_offset_ns -= 300'000'000;  // as if it had lain somewhere for 300 ms
  EXPECT_EQ(rig.refusal_of(*peer, peer->send(joint_goal(1, 0.4))), wire::REFUSAL_REASON_EXPIRED);
}

TEST(Link, ClosesAfterFiveProtocolErrorsAndLivesOn) {
  LinkRig rig;
  auto peer = rig.commander();
  peer->sequence = 0;  // repeats
  for (int i = 0; i < 5; ++i) {
    peer->sequence = 0;
    peer->send(joint_goal(1, 0.4));
  }
  rig.cycles(5);
  peer->take();
  EXPECT_FALSE(peer->is_open());
  Peer noisy(rig.link->port(), rig.clock);
  noisy.send_raw("\xff\xff\xff garbage");
  rig.cycles(5);
  EXPECT_TRUE(rig.commander());
}

TEST(Link, ASilentCommanderLosesTheLeaseAndTheArmStops) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->send(joint_goal(1, 1.4));
  rig.cycles(40);
  ASSERT_EQ(rig.link->mode(), Mode::kServo);
  rig.cycles(60);
  EXPECT_TRUE(rig.link->mode() == Mode::kStopping || rig.link->mode() == Mode::kHold);
  rig.cycles(60);
  EXPECT_EQ(rig.link->mode(), Mode::kHold);
}

TEST(Link, AHangUpStopsTheArmAtOnce) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->send(joint_goal(1, 1.4));
  rig.cycles(30);
  peer->hang_up();
  rig.cycles(3);
  EXPECT_NE(rig.link->mode(), Mode::kServo);
}

/// A thousand heartbeats that a peer sent at once.
void flood(Peer& peer) {
  wire::Envelope beat;
  beat.mutable_heartbeat();
  for (int i = 0; i < 1000; ++i) peer.send(beat);
}

std::unique_ptr<Peer> observer(LinkRig& rig) {
  auto peer = std::make_unique<Peer>(rig.link->port(), rig.clock);
  peer->send(rig.hello(wire::ROLE_OBSERVE));
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.has_hello_reply(); }));
  return peer;
}

TEST(Link, WorksOffAFloodInPiecesAndLosesNothing) {
  LinkRig rig;
  auto peer = observer(rig);
  flood(*peer);
  std::map<std::int64_t, int> answered;  // by the time of the step
  int all = 0;
  for (int i = 0; i < 2000 && all < 1000; ++i) {
    rig.cycle();
    for (const wire::Envelope& e : peer->take())
      if (e.has_heartbeat_reply()) ++answered[e.heartbeat_reply().arm_receive_time_ns()], ++all;
  }
  EXPECT_GE(all, 1000);
  for (const auto& [time_ns, count] : answered) EXPECT_LE(count, 32);
}

TEST(Link, TakesAStopBeforeWhateverElseCame) {
  LinkRig rig;
  auto flooding = observer(rig), stopping = observer(rig);
  flood(*flooding);
  wire::Envelope stop;
  stop.mutable_stop();
  EXPECT_TRUE(rig.answer_to(*stopping, stopping->send(stop)).has_accepted());
  rig.link.reset();
  rig.files.reset();
  std::ifstream in(rig.folder / "ticks.mcap", std::ios::binary);
  RecordingReader reader(in);
  std::map<std::int64_t, std::vector<bool>> is_accepted;  // what was answered in a step, in order
  std::int64_t at_stop = 0;
  for (RecordedMessage message; reader.next(message);) {
    wire::LinkRecord record;
    if (message.topic != "/link" || !record.ParseFromString(message.data)) continue;
    const bool is_stop = record.to_controller() && record.envelope().has_stop();
    if (is_stop) at_stop = record.time_ns();
    if (!record.to_controller()) is_accepted[record.time_ns()].push_back(record.envelope().has_accepted());
  }
  ASSERT_GT(is_accepted[at_stop].size(), 1u);
  EXPECT_TRUE(is_accepted[at_stop].front());
}

TEST(Link, TakesTheStopOfAPeerThatHungUp) {
  LinkRig rig;
  auto commander = rig.powered_commander();
  ASSERT_TRUE(rig.answer_to(*commander, commander->send(joint_goal(7, 0.4, 0.1))).has_accepted());
  Peer passer_by(rig.link->port(), rig.clock);
  wire::Envelope stop;
  stop.mutable_stop();
  passer_by.send(stop);
  passer_by.hang_up();
  const auto told = rig.wait_for(*commander, [](const auto& e) { return e.has_stop_report(); }, 100);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->stop_report().code(), static_cast<std::uint32_t>(FaultCode::kStopAsked));
}

TEST(Link, RefusesTimesWhoseDifferencesOverflow) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->clock_offset_ns = std::numeric_limits<std::int64_t>::min() / 2;
  wire::Envelope beat;
  beat.mutable_heartbeat();
  const wire::Envelope answer = rig.answer_to(*peer, peer->send(beat));
  EXPECT_EQ(answer.refusal().reason(), wire::REFUSAL_REASON_MALFORMED);
  EXPECT_NE(answer.refusal().text().find("sent_time_ns"), std::string::npos) << answer.refusal().text();
}

TEST(Link, AGoalThatAStopFollowedInTheSameStepNeverActs) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  wire::Envelope stop;
  stop.mutable_stop();
  const std::uint64_t goal = peer->send(joint_goal(7, 0.4));
  peer->send(stop);
  const wire::Envelope answer = rig.answer_to(*peer, goal);
  EXPECT_EQ(answer.refusal().reason(), wire::REFUSAL_REASON_WRONG_STATE);
  EXPECT_EQ(answer.refusal().text(), "stopped before it began");
  rig.cycles(20);
  EXPECT_EQ(rig.loop->mode(), Mode::kHold);
}

}  // namespace
}  // namespace armsight::arm::test
