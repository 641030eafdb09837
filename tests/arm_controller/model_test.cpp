// The model in force between tick, disk and peers: nothing is told before it is saved, and a disk that was full is
// mended.
#include <gtest/gtest.h>

#include "arm_controller/state_folder.hpp"
#include "tests/arm_controller/link_rig.hpp"

namespace armsight::arm::test {
namespace {

wire::Envelope proposal(const LinkRig& rig, std::uint64_t parent) {
  wire::Envelope envelope;
  wire::ModelProposal& p = *envelope.mutable_model_proposal();
  p.set_parent_revision(parent);
  to_wire(rig.robot.camera_hint_T_C_B, p.mutable_base_in_camera());
  for (int i = 0; i < 5; ++i) p.add_beta_rad(0.01 * i);
  return envelope;
}

wire::Envelope goal_on_model(std::uint64_t id) {
  wire::Envelope envelope;
  wire::JointGoal& goal = *envelope.mutable_joint_goal();
  goal.set_goal(id);
  for (const double q : {0.4, 0.1, -0.3, 1.0, 0.2}) goal.add_q_real_rad(q);
  goal.set_speed_scale(1.0);
  goal.set_valid_for_ns(100'000'000);
  return envelope;
}

/// model.yaml cannot be written while a folder stands in its place.
class BlockedFile {
 public:
  explicit BlockedFile(const LinkRig& rig) : path_(rig.folder / "model.yaml") {
    std::filesystem::create_directories(path_ / "in the way");
  }
  void clear() { std::filesystem::remove_all(path_); }

 private:
  std::filesystem::path path_;
};

/// The highest revision that a message names.
std::uint64_t revision_in(const wire::Envelope& e) {
  return std::max({e.arm_state().model_revision(), e.goal_status().model_revision(), e.filter_report().model_revision(),
                   e.model_update().revision()});
}

TEST(Model, IsSavedBeforeItIsPublishedAndLoadedAtTheNextStart) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  peer->send(proposal(rig, 0));
  EXPECT_TRUE(
      rig.wait_for(*peer, [](const auto& e) { return e.has_model_update() && e.model_update().revision() == 1; }));
  EXPECT_TRUE(std::filesystem::exists(rig.folder / "model.yaml"));
  EXPECT_EQ(rig.refusal_of(*peer, peer->send(proposal(rig, 0))), wire::REFUSAL_REASON_STALE_MODEL);
  const StartModel loaded = load_model_in_force(rig.folder, rig.robot);
  EXPECT_EQ(loaded.model.revision, 1u);
  EXPECT_EQ(loaded.model.beta[4], 0.04);
  EXPECT_EQ(loaded.source, ModelSource::kLoaded);
}

// After a crash a number that nobody saved is given again, to another model.
TEST(Model, NoMessageNamesARevisionThatIsNotOnDisk) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  BlockedFile blocked(rig);
  peer->send(proposal(rig, 0));
  peer->send(goal_on_model(3));
  const auto leak = rig.wait_for(*peer, [](const auto& e) { return revision_in(e) > 0; }, 400);
  EXPECT_FALSE(leak) << "a message of kind " << leak->body_case();
}

TEST(Model, ADiskThatWasFullIsMendedByMakingRoomAndClearing) {
  LinkRig rig;
  auto peer = rig.powered_commander();
  BlockedFile blocked(rig);
  peer->send(proposal(rig, 0));
  ASSERT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.fault_report().code() == 303; }));
  blocked.clear();
  wire::Envelope clear;
  clear.mutable_mode_request()->set_mode(wire::MODE_HOLD);
  clear.mutable_mode_request()->set_clear_fault(true);
  EXPECT_TRUE(rig.answer_to(*peer, peer->send(clear)).has_accepted());
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.model_update().revision() == 1; }));
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.arm_state().mode() == wire::MODE_HOLD; }));
  EXPECT_EQ(load_model_in_force(rig.folder, rig.robot).model.revision, 1u);
  const auto again = rig.wait_for(*peer, [](const auto& e) { return e.has_fault_report(); }, 500);
  EXPECT_FALSE(again) << again->fault_report().text();
}

}  // namespace
}  // namespace armsight::arm::test
