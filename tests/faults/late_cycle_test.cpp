// Row 11: the cycle begins late, by one to fifty periods. Counted; ten in a row stop; and what the drives did meanwhile
// by themselves is never undone.
#include "tests/faults/fault_rig.hpp"

namespace armsight::faults {
namespace {

class LateCycle : public ::testing::Test {
 protected:
  FaultRig rig;
  void SetUp() override { ASSERT_TRUE(rig.start_moving()); }
};

TEST_F(LateCycle, NineInARowAreCarriedAndCounted) {
  for (int i = 0; i < 9; ++i) rig.cycle(1);
  rig.cycles(20);
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
  EXPECT_GT(rig.fastest_rad_s(), 0.4);
  EXPECT_EQ(rig.statistics.missed.load(), 9U);
}

TEST_F(LateCycle, TenInARowStop) {
  const Time began = rig.now;
  for (int i = 0; i < 10; ++i) rig.cycle(1);
  rig.cycles(50);
  EXPECT_LT(rig.largest_step_rad(began), 0.5 * 0.004 * 1.2) << "no set-point jumps back to where the arm was";
  EXPECT_TRUE(rig.all_drives(DriveState::kQuickStopActive));
  EXPECT_EQ(rig.fastest_rad_s(), 0.0);
}

/// The drives' own deadline is five periods, the host's lease fifty.
TEST_F(LateCycle, ByAnyLengthMovesOnOrStopsForGood) {
  for (int late = 1; late <= 50; ++late) {
    FaultRig one;
    ASSERT_TRUE(one.start_moving());
    one.cycle(late);
    one.cycles(100);
    const bool goes_on = one.all_drives(DriveState::kOperationEnabled) && one.fastest_rad_s() > 0.3;
    const bool is_stopped = one.no_drive(DriveState::kOperationEnabled) && one.fastest_rad_s() == 0.0;
    const bool lost_its_lease = one.all_drives(DriveState::kOperationEnabled) && one.is_still() && late >= 49;
    EXPECT_TRUE(goes_on || (is_stopped && late >= 4) || lost_its_lease) << late << " periods";
  }
}

}  // namespace
}  // namespace armsight::faults
