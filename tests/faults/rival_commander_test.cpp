// Row 13: a second commander, a stolen session, a record that is played again, a lease that ran out, another arm's
// model. None of them moves the arm; and a Stop is taken from everybody. Certificates: with TLS.
#include "tests/faults/linked_rig.hpp"

namespace armsight::faults {
namespace {

class RivalCommander : public ::testing::Test {
 protected:
  LinkedRig rig;
  std::unique_ptr<Peer> host = rig.powered_commander();
  Time began = rig.now;

  static wire::Envelope goal() {
    wire::Envelope envelope = LinkedRig::joint_goal(FaultRig::far_goal());
    envelope.mutable_joint_goal()->set_valid_for_ns(60'000'000'000);
    return envelope;
  }
  void expect_unmoved() {
    rig.cycles(100);
    EXPECT_LT(rig.travelled_rad(began), kCount_rad);
    EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
  }
};

TEST_F(RivalCommander, GetsNoLeaseAndMovesNothing) {
  auto rival = rig.connect();
  wire::Envelope lease;
  lease.mutable_lease_request();
  EXPECT_EQ(rig.refusal_of(*rival, rival->send(lease)), wire::REFUSAL_REASON_LEASE_TAKEN);
  EXPECT_EQ(rig.refusal_of(*rival, rival->send(goal())), wire::REFUSAL_REASON_NO_LEASE);
  expect_unmoved();
}

TEST_F(RivalCommander, WithAStolenSessionMovesNothing) {
  auto rival = rig.connect();
  rival->session = host->session;
  EXPECT_EQ(rig.refusal_of(*rival, rival->send(goal())), wire::REFUSAL_REASON_SESSION);
  expect_unmoved();
}

TEST_F(RivalCommander, PlayingARecordAgainMovesNothing) {
  wire::Envelope record = goal();
  host->send(record);
  rig.cycles(50);
  host->take();
  wire::Envelope stop;
  stop.mutable_stop();
  host->send(stop);
  rig.cycles(150);
  ASSERT_TRUE(rig.is_still());
  began = rig.now;
  record.set_protocol_version(wire::kProtocolVersion);
  record.set_session(host->session);
  record.set_sequence(host->sequence - 1);
  record.set_sent_time_ns(to_ns(rig.now) + host->clock_offset_ns);
  host->send_raw(record.SerializeAsString());  // on the very connection
  rig.cycles(50);
  auto rival = rig.connect();
  rival->send_raw(record.SerializeAsString());  // and on another
  expect_unmoved();
}

TEST_F(RivalCommander, WhoseLeaseRanOutMovesNothing) {
  rig.beating.clear();
  rig.cycles(100);
  EXPECT_EQ(rig.refusal_of(*host, host->send(goal())), wire::REFUSAL_REASON_NO_LEASE);
  expect_unmoved();
}

TEST_F(RivalCommander, WithAnotherArmsModelIsTurnedAway) {
  Peer rival(rig.link->port(), rig.clock);
  wire::Envelope hello = rig.hello(wire::ROLE_COMMAND);
  hello.mutable_hello()->set_model_hash(hello.hello().model_hash() + 1);
  EXPECT_EQ(rig.refusal_of(rival, rival.send(hello)), wire::REFUSAL_REASON_MODEL_HASH);
  rival.send(goal());
  expect_unmoved();
}

TEST_F(RivalCommander, MayAlwaysStop) {
  host->send(goal());
  rig.cycles(125);
  ASSERT_GT(rig.fastest_rad_s(), 0.4);
  Peer anybody(rig.link->port(), rig.clock);  // not even a Hello
  wire::Envelope stop;
  stop.mutable_stop();
  anybody.send(stop);
  rig.cycles(100);
  EXPECT_TRUE(rig.is_still());
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
  EXPECT_GT((rig.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff(), 0.1);
}

}  // namespace
}  // namespace armsight::faults
