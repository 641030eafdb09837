// Rows 6 and 7: frames that get lost, come twice, late or out of order; and frames whose bits a gateway changed so that
// the checksum is right.
#include "tests/faults/fault_rig.hpp"
#include "tools/sim/random.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;
using arm::FaultCode;
constexpr double kStop_rad = 0.5 * 0.05 + 0.5 * 0.5 / (2 * 20.0);  ///< a few periods at full speed, then the ramp

class DamagedTraffic : public ::testing::Test {
 protected:
  FaultRig rig;

  /// The next `count` frames with this identifier pass so.
  void damage(std::uint32_t id, int count, const sim::Passage& passage) {
    rig.bus->set_judge([id, left = count, passage](const CanFrame& frame, Time) mutable {
      return frame.id == id && left-- > 0 ? passage : sim::Passage{};
    });
  }
  void expect_all_stopped(Time since, Duration in) {
    for (int node = 1; node <= kNodes; ++node) {
      const auto left = rig.left(node, DriveState::kOperationEnabled, since);
      ASSERT_TRUE(left) << "drive " << node << " goes on";
      EXPECT_LE(*left - since, in) << "drive " << node;
    }
    EXPECT_EQ(rig.fastest_rad_s(), 0.0);
    EXPECT_LT(rig.travelled_rad(since), kStop_rad);
  }
  bool arrives() {
    return rig.cycle_until([&] { return (rig.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff() < 5e-3; }, 1500);
  }
};

class LostFrames : public DamagedTraffic {};

TEST_F(LostFrames, TwoSamplesMissingInARowAreBridged) {
  ASSERT_TRUE(rig.start_moving());
  for (int i = 0; i < 20; ++i) {
    damage(kTpdo1Base + 3, 2, {.is_lost = true});
    rig.cycles(5);
    ASSERT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
    ASSERT_GT(rig.fastest_rad_s(), 0.4) << "bridged, not stopped";
  }
  rig.bus->set_judge({});
  EXPECT_TRUE(arrives());
}

TEST_F(LostFrames, TheThirdSampleMissingInARowStops) {
  ASSERT_TRUE(rig.start_moving());
  const Time began = rig.now;
  damage(kTpdo1Base + 3, 3, {.is_lost = true});
  rig.cycles(100);
  expect_all_stopped(began, 5 * rig.period());
  EXPECT_EQ(rig.named(), FaultCode::kFeedbackMissing);
}

TEST_F(LostFrames, ThatComeTwiceChangeNothing) {
  ASSERT_TRUE(rig.start_moving());
  sim::Random random(1, 900);
  rig.bus->set_judge([&](const CanFrame&, Time) { return sim::Passage{.comes_twice = random.unit() < 0.1}; });
  EXPECT_TRUE(arrives());
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
}

/// Whatever is lost, doubled, late or overtaken: the arm goes on smoothly or stops as a whole.
TEST_F(LostFrames, AtAnyRateTheArmGoesOnOrStopsAsAWhole) {
  for (const double share : {0.001, 0.01, 0.1})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      FaultRig one;
      ASSERT_TRUE(one.start_moving());
      sim::Random random(seed, 901);
      one.bus->set_judge([&](const CanFrame&, Time) {
        sim::Passage passage;
        passage.is_lost = random.unit() < share;
        passage.comes_twice = random.unit() < share;
        if (random.unit() < share) passage.delay = Duration{static_cast<std::int64_t>(random.uniform(0.0, 6e6))};
        return passage;
      });
      const std::string what = "share " + std::to_string(share) + ", seed " + std::to_string(seed);
      for (int i = 0; i < 800; ++i) {
        one.cycle();
        ASSERT_LT(one.fastest_rad_s(), 0.65) << what << ": 0.5 rad/s and what the drive's lag makes of a gap";
      }
      const bool has_arrived = (one.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff() < 5e-3;
      const bool is_stopped = one.no_drive(DriveState::kOperationEnabled) && one.fastest_rad_s() == 0.0;
      EXPECT_TRUE((has_arrived && one.all_drives(DriveState::kOperationEnabled)) || is_stopped) << what;
      EXPECT_TRUE(has_arrived || share > 0.005) << what;
    }
}

class CorruptFrames : public DamagedTraffic {};

TEST_F(CorruptFrames, APositionFartherThanAJointCanGoIsRefusedAndStops) {
  for (const int bit : {11, 13, 14, 30}) {
    FaultRig one;
    ASSERT_TRUE(one.start_moving());
    bool is_done = false;
    one.bus->set_judge([&](const CanFrame& frame, Time) {
      sim::Passage passage;
      if (is_done || frame.id != kTpdo1Base + 3u) return passage;
      is_done = true;
      passage.altered = frame;
      passage.altered->data[static_cast<std::size_t>(2 + bit / 8)] ^= static_cast<std::uint8_t>(1 << bit % 8);
      return passage;
    });
    const Time began = one.now;
    one.cycles(100);
    for (int node = 1; node <= kNodes; ++node)
      EXPECT_TRUE(one.left(node, DriveState::kOperationEnabled, began)) << "bit " << bit << ", drive " << node;
    EXPECT_LT(one.travelled_rad(began), kStop_rad) << "bit " << bit;
    EXPECT_LT(one.largest_step_rad(began), 0.5 * 0.004 * 1.2) << "bit " << bit << ": a set-point followed it";
    EXPECT_EQ(one.named(), FaultCode::kEncoderStep) << "bit " << bit;
  }
}

TEST_F(CorruptFrames, ATargetChangedOnItsWayIsRefusedByTheDriveAndStopsTheOthers) {
  ASSERT_TRUE(rig.start_moving());
  bool is_done = false;
  rig.bus->set_judge([&](const CanFrame& frame, Time) {
    sim::Passage passage;
    if (is_done || frame.id != kRpdo1Base + 3u) return passage;
    is_done = true;
    passage.altered = frame;
    passage.altered->data[3] ^= 0x40;  // 16384 counts, half a turn
    return passage;
  });
  const Time began = rig.now;
  rig.cycles(100);
  expect_all_stopped(began, 5 * rig.period());
}

}  // namespace
}  // namespace armsight::faults
