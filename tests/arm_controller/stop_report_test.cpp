// Every stop names its cause, whose side it was and the evidence; and after a fault the black box comes over the link.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/arm_controller/link_rig.hpp"

namespace armsight::arm::test {
namespace {

class StopReport : public ::testing::Test {
 protected:
  void start_moving() {
    commander_ = rig_.powered_commander();
    observer_ = std::make_unique<Peer>(rig_.link->port(), rig_.clock);
    observer_->send(rig_.hello(wire::ROLE_OBSERVE));
    ASSERT_TRUE(rig_.wait_for(*observer_, [](const auto& e) { return e.has_hello_reply(); }, 10));
    wire::Envelope goal;
    wire::JointGoal& g = *goal.mutable_joint_goal();
    g.set_goal(1);
    for (const double q : {0.9, 0.1, -0.3, 1.0, 0.2}) g.add_q_real_rad(q);
    g.set_speed_scale(0.3);
    g.set_valid_for_ns(1'000'000'000);
    commander_->send(goal);
    rig_.cycles(20);
    ASSERT_EQ(rig_.loop->mode(), Mode::kServo);
  }
  /// What the observer is told; its own heartbeats are nobody's lease.
  wire::StopReport told() {
    const auto e = rig_.wait_for(*observer_, [](const auto& m) { return m.has_stop_report(); }, 100);
    EXPECT_TRUE(e);
    return e ? e->stop_report() : wire::StopReport{};
  }

  LinkRig rig_;
  std::unique_ptr<Peer> commander_, observer_;
};

TEST_F(StopReport, NamesTheLinkWhereTheCommanderFellSilent) {
  start_moving();
  const wire::StopReport stop = told();
  EXPECT_EQ(stop.code(), 401u);
  EXPECT_EQ(stop.side(), "link");
  EXPECT_TRUE(stop.text().starts_with("the commander was silent longer than its lease, last heard 20")) << stop.text();
}

TEST_F(StopReport, NamesTheLinkWhereTheConnectionClosed) {
  start_moving();
  commander_->hang_up();
  const wire::StopReport stop = told();
  EXPECT_EQ(stop.code(), 402u);
  EXPECT_EQ(stop.side(), "link");
}

TEST_F(StopReport, NamesTheHostWhereItLeft) {
  start_moving();
  wire::Envelope bye;
  bye.mutable_bye();
  commander_->send(bye);
  const wire::StopReport stop = told();
  EXPECT_EQ(stop.code(), 502u);
  EXPECT_EQ(stop.side(), "host");
}

TEST_F(StopReport, NamesTheOperatorWhereStopWasSent) {
  start_moving();
  wire::Envelope envelope;
  envelope.mutable_stop();
  observer_->send(envelope);
  const wire::StopReport stop = told();
  EXPECT_EQ(stop.code(), 601u);
  EXPECT_EQ(stop.side(), "operator");
}

TEST_F(StopReport, IsToldToWhoeverComesLater) {
  start_moving();
  wire::Envelope envelope;
  envelope.mutable_stop();
  observer_->send(envelope);
  told();
  observer_ = std::make_unique<Peer>(rig_.link->port(), rig_.clock);
  observer_->send(rig_.hello(wire::ROLE_OBSERVE));
  EXPECT_EQ(told().code(), 601u);
}

TEST(BlackBoxOverTheLink, ComesInPiecesAndIsTheFile) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  const auto ask = [&](std::uint64_t offset) {
    wire::Envelope request;
    request.mutable_black_box_request()->set_offset(offset);
    peer->send(request);
    const auto e = rig.wait_for(*peer, [](const auto& m) { return m.has_black_box_chunk(); }, 20);
    EXPECT_TRUE(e);
    return e ? e->black_box_chunk() : wire::BlackBoxChunk{};
  };
  EXPECT_EQ(ask(0).name(), "") << "no fault, no box";
  rig.bus.drive(2).is_silent = true;
  ASSERT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.has_fault_report(); }, 20));
  rig.cycles(3);
  std::string bytes, name;
  for (int i = 0; i < 500; ++i) {
    const wire::BlackBoxChunk chunk = ask(bytes.size());
    name = chunk.name();
    bytes += chunk.data();
    if (bytes.size() >= chunk.total_bytes()) break;
  }
  ASSERT_FALSE(name.empty());
  std::ifstream in(rig.folder / name, std::ios::binary);
  std::stringstream file;
  file << in.rdbuf();
  EXPECT_GT(bytes.size(), 100'000u);
  EXPECT_TRUE(bytes == file.str());
}

TEST(LastPosition, IsSavedAndComparedAtTheNextStart) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  rig.cycles(300);
  std::ifstream in(rig.folder / "position.txt");
  std::string magic, hash;
  double q1 = 0.0;
  ASSERT_TRUE(in >> magic >> hash >> q1);
  EXPECT_NEAR(q1, 0.1, 1e-3);
}

}  // namespace
}  // namespace armsight::arm::test
