// Row 16: the same again, bit by bit: a whole run of arm and controller, and a record that is gone through twice.
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "arm_controller/black_box.hpp"
#include "arm_controller/black_box_replay.hpp"
#include "tests/faults/fault_rig.hpp"
#include "tools/sim/random.hpp"

namespace armsight::faults {
namespace {

class RecordedRig : public FaultRig {
 public:
  arm::BlackBox box;

  /// A move that is stopped, another one among lost frames, and a node that dies.
  void live() {
    ASSERT_TRUE(start_moving());
    mailboxes.stop.set();
    cycles(150);
    sim::Random random(3, 930);
    bus->set_judge([&random](const CanFrame&, Time) { return sim::Passage{.is_lost = random.unit() < 0.002}; });
    send_goal(posture(-0.5, 0.2, 0.4, 1.5, -0.4), 0.7);
    cycles(400);
    node(2).power_off(now);
    cycles(50);
    bus->set_judge({});
  }

 protected:
  void after_cycle() override {
    tape.checkpoints.take(
        [this](std::uint64_t done, std::span<const std::byte> bytes) { box.keep_checkpoint(done, bytes); });
    arm::TickRecord record;
    arm::OrdersRecord orders;
    while (tape.ticks.pop(record)) {
      while (tape.orders.pop(orders)) box.keep(orders);
      box.keep(record);
    }
    FaultRig::after_cycle();
  }
};

TEST(RepeatedRun, OfTheSameArmPutsTheSameBitsOnTheBus) {
  RecordedRig first, second;
  first.live();
  second.live();
  ASSERT_EQ(first.log.size(), second.log.size());
  ASSERT_GT(first.log.size(), 10'000U);
  for (std::size_t i = 0; i < first.log.size(); ++i) {
    ASSERT_EQ(first.log[i].time, second.log[i].time) << "frame " << i;
    ASSERT_EQ(first.log[i].frame, second.log[i].frame) << "frame " << i;
  }
}

TEST(RepeatedRun, OfARecordGivesTheSameOutputsTwice) {
  RecordedRig rig;
  rig.live();
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("armsight-repeated-" + std::to_string(getpid()) + ".mcap");
  wire::RecordingInfo info;
  std::stringstream text;
  text << std::ifstream(ARMSIGHT_HOME "/arm_controller/config/ego_right_arm.yaml").rdbuf();
  info.set_configuration(text.str());
  rig.box.write(file, info);
  for (int time = 1; time <= 2; ++time) {
    const arm::BlackBoxResult result = arm::replay_black_box(file);
    EXPECT_FALSE(result.difference) << *result.difference;
    EXPECT_GT(result.cycles, 700U);
    EXPECT_GT(result.frames_compared, 7 * 500U);
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace armsight::faults
