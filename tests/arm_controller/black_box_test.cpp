// A black box holds two thousand cycles and more, goes through again bit by bit in the executable that wrote it, and
// reports one flipped bit of an input.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "arm_controller/black_box_replay.hpp"
#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"
#include "tests/arm_controller/arm_rig.hpp"
#include "tests/replay/edited_recording.hpp"

namespace armsight::arm::test {
namespace {

namespace fs = std::filesystem;

class BlackBoxFile : public ::testing::Test {
 protected:
  ~BlackBoxFile() override { fs::remove_all(folder_); }

  /// A move, a look-alike of a life, and a node that falls silent.
  void live(int cycles) {
    ASSERT_TRUE(rig_.power_up());
    JointVector goal(5);
    goal << 0.6, 0.2, -0.3, 1.2, 0.3;
    rig_.mailboxes.goal.put(rig_.joint_goal(1, goal));
    rig_.mailboxes.hand.put({{7, 2}, 0.7, 400});
    rig_.cycles(cycles);
    goal[0] = -0.3;
    rig_.mailboxes.goal.put(rig_.joint_goal(3, goal));
    rig_.cycles(100);
    rig_.bus.drive(2).is_silent = true;
    ASSERT_TRUE(rig_.bring_to(Mode::kFault, 10));
    wire::RecordingInfo info;
    std::ifstream robot(kRobotFile);
    std::stringstream text;
    text << robot.rdbuf();
    info.set_configuration(text.str());
    rig_.box.write(file_, info);
  }

  /// The same file with one message changed.
  fs::path edited(const std::function<void(RecordedMessage&)>& edit) {
    const fs::path out_file = folder_ / "edited.mcap";
    armsight::test::edit_recording(file_, out_file, edit);
    return out_file;
  }

  /// Flips one bit of the nth frame that was received with this identifier.
  fs::path with_flipped_frame(std::uint32_t id, int nth, std::size_t byte, char bit) {
    int seen = 0;
    return edited([&](RecordedMessage& message) {
      wire::CanRecord frame;
      if (message.topic != "/can" || !frame.ParseFromString(message.data)) return;
      if (frame.id() != id || frame.is_sent() || frame.is_own_echo() || ++seen != nth) return;
      (*frame.mutable_data())[byte] = static_cast<char>(frame.data()[byte] ^ bit);
      message.data = frame.SerializeAsString();
    });
  }

  /// The same file with the first message of this topic that `change` takes (answers true) changed.
  template <typename Message>
  fs::path with_first(const std::string& topic, const std::function<bool(Message&)>& change) {
    bool is_done = false;
    return edited([&](RecordedMessage& message) {
      Message parsed;
      if (is_done || message.topic != topic || !parsed.ParseFromString(message.data) || !change(parsed)) return;
      is_done = true;
      message.data = parsed.SerializeAsString();
    });
  }

  /// Why the file cannot be gone through; "": it can.
  static std::string complaint(const fs::path& file) {
    try {
      replay_black_box(file);
    } catch (const NotReplayable& e) {
      return e.what();
    }
    return "";
  }

  /// What it says of a file whose first messages to a cycle were changed.
  std::string complaint_with_orders(const std::function<void(TickInbox&)>& change) {
    return complaint(with_first<wire::CycleInput>("/input", [&](wire::CycleInput& input) {
      if (input.orders().size() != sizeof(TickInbox)) return false;
      TickInbox inbox;
      std::memcpy(static_cast<void*>(&inbox), input.orders().data(), sizeof inbox);
      change(inbox);
      input.set_orders(&inbox, sizeof inbox);
      return true;
    }));
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("armsight-blackbox-" + std::to_string(getpid()));
  fs::path file_ = (fs::create_directories(folder_), folder_ / "box.mcap");
  ArmRig rig_;
};

TEST_F(BlackBoxFile, GoesThroughAgainBitByBit) {
  live(4000);
  const BlackBoxResult result = replay_black_box(file_);
  EXPECT_FALSE(result.difference) << *result.difference;
  EXPECT_GE(result.cycles, kKeptTicks);
  EXPECT_LE(result.cycles, kKeptTicks + kCheckpointEvery);
  EXPECT_GT(result.frames_compared, 7 * result.cycles);
}

TEST_F(BlackBoxFile, OfAShortLifeBeginsWithTheFirstCycle) {
  live(300);
  const BlackBoxResult result = replay_black_box(file_);
  EXPECT_FALSE(result.difference) << *result.difference;
  EXPECT_GT(result.cycles, 400u);
}

TEST_F(BlackBoxFile, ReportsOneFlippedBitOfAPosition) {
  live(4000);
  const BlackBoxResult result = replay_black_box(with_flipped_frame(0x183, 900, 2, 0x01));
  ASSERT_TRUE(result.difference);
  EXPECT_TRUE(result.difference->starts_with("cycle ")) << *result.difference;
}

TEST_F(BlackBoxFile, ReportsOneFlippedBitOfAStatusword) {
  live(4000);
  const BlackBoxResult result = replay_black_box(with_flipped_frame(0x185, 700, 0, 0x08));
  ASSERT_TRUE(result.difference);
  EXPECT_NE(result.difference->find("recorded"), std::string::npos) << *result.difference;
}

TEST_F(BlackBoxFile, ReportsAMessageThatWasChanged) {
  live(1500);
  const std::uint64_t while_moving = rig_.statistics.cycles.load() - 60;
  const fs::path changed = edited([&](RecordedMessage& message) {
    wire::CycleInput input;
    if (message.topic != "/input" || !input.ParseFromString(message.data) || input.cycle() != while_moving) return;
    input.set_stop(true);
    message.data = input.SerializeAsString();
  });
  ASSERT_TRUE(replay_black_box(changed).difference);
}

TEST_F(BlackBoxFile, OfAnotherExecutableIsRefused) {
  live(300);
  const fs::path changed = edited([](RecordedMessage& message) {
    wire::CheckpointRecord checkpoint;
    if (message.topic != "/state" || !checkpoint.ParseFromString(message.data)) return;
    checkpoint.set_build_id("00");
    message.data = checkpoint.SerializeAsString();
  });
  EXPECT_THROW(replay_black_box(changed), NotReplayable);
}

TEST_F(BlackBoxFile, WithAFrameThatNoBusCarriesIsRefused) {
  live(300);
  for (const bool is_sent : {true, false}) {
    const auto change = [&](const std::function<void(wire::CanRecord&)>& set) {
      return complaint(with_first<wire::CanRecord>("/can", [&](wire::CanRecord& frame) {
        if (frame.is_sent() != is_sent) return false;
        set(frame);
        return true;
      }));
    };
    EXPECT_NE(change([](auto& f) { f.set_data(std::string(9, 'x')); }).find("at most 8"), std::string::npos);
    EXPECT_NE(change([](auto& f) { f.set_data(std::string(200, 'x')); }).find("200 bytes"), std::string::npos);
    EXPECT_NE(change([](auto& f) { f.set_id(0x800); }).find("at most 0x7FF"), std::string::npos);
    EXPECT_NE(change([](auto& f) { f.set_send_result(3); }).find("send_result = 3"), std::string::npos);
  }
}

TEST_F(BlackBoxFile, WithMessagesThatNoLinkHandsOnIsRefused) {
  live(300);
  EXPECT_EQ(complaint_with_orders([](TickInbox&) {}), "");
  const auto says = [&](const char* what, const std::function<void(TickInbox&)>& change) {
    const std::string complaint = complaint_with_orders(change);
    EXPECT_NE(complaint.find(what), std::string::npos) << what << ": " << complaint;
  };
  says("looks", [](TickInbox& inbox) { inbox.look_count = kMaxLooks + 1; });
  says("look", [](TickInbox& inbox) { inbox.look_count = 1; });  // without angles
  says("wish", [](TickInbox& inbox) { inbox.mode = {{7, 9}, static_cast<PowerWish>(2), false}; });
  says("goal", [](TickInbox& inbox) { inbox.goal.emplace().kind = static_cast<GoalKind>(3); });
  says("goal", [](TickInbox& inbox) { inbox.goal.emplace(); });          // without angles
  says("proposal", [](TickInbox& inbox) { inbox.proposal.emplace(); });  // without offsets
}

TEST_F(BlackBoxFile, WithALeaseThatEndedInNoKnownWayIsRefused) {
  live(300);
  const fs::path changed = with_first<wire::CycleInput>("/input", [](wire::CycleInput& input) {
    input.set_has_lease(true);
    input.set_lease_why_free(9999);
    return true;
  });
  EXPECT_NE(complaint(changed).find("lease_why_free = 9999"), std::string::npos);
}

}  // namespace
}  // namespace armsight::arm::test
