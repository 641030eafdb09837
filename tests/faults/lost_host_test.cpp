// Row 2: the host is gone: killed, stopped, its cable pulled, its link half open or dribbling. The stop begins within
// the lease and a cycle, the way is bounded, and the arm holds, powered. With real programs: lost_programs_test.
#include <sys/socket.h>

#include "tests/faults/linked_rig.hpp"

namespace armsight::faults {
namespace {

using namespace std::chrono_literals;
constexpr double kSpeed_rad_s = 0.5, kAcceleration_rad_s2 = 4.0, kJerk_rad_s3 = 80.0;  // of the shipped arm
constexpr double kDriveLag_s = 0.025;
constexpr double kBraking_s = kSpeed_rad_s / kAcceleration_rad_s2 + kAcceleration_rad_s2 / kJerk_rad_s3;
/// v·t, then the jerk-limited brake's half of v·t, and what the drive lags behind.
constexpr double way_rad(double after_s) { return kSpeed_rad_s * (after_s + kBraking_s / 2 + kDriveLag_s); }

/// When set-points of joint 1 first came closer than at full speed: 10 or 11 counts a cycle.
std::optional<Time> stop_began(const FaultRig& rig, Time since) {
  std::optional<std::int32_t> last;
  for (const BusLine& line : rig.log) {
    const auto command = decode_rpdo1(line.frame, 1);
    if (!command || line.time <= since) continue;
    if (last && std::abs(command->target_counts - *last) < 9) return line.time;
    last = command->target_counts;
  }
  return std::nullopt;
}

void expect_stops_and_holds(FaultRig& rig, Time lost, Duration within, double within_rad) {
  const auto began = stop_began(rig, lost);
  ASSERT_TRUE(began) << "the arm goes on";
  EXPECT_LE(*began - lost, within);
  EXPECT_LE(rig.travelled_rad(lost), within_rad);
  EXPECT_TRUE(rig.is_still());
  EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled)) << "powered";
  EXPECT_GT((rig.q_rad() - FaultRig::far_goal()).cwiseAbs().maxCoeff(), 0.1) << "it went on to its goal";
}

class LostHost : public ::testing::Test {
 protected:
  LinkedRig rig;
  std::unique_ptr<Peer> host = rig.powered_commander();
  Duration lease = seconds_to_duration(rig.robot.controller.lease_s) + rig.period() + 2ms;  // 2 ms: of the bus

  void SetUp() override {
    host->send(LinkedRig::joint_goal(FaultRig::far_goal()));
    rig.cycles(125);
    ASSERT_GT(rig.fastest_rad_s(), 0.4);
    wire::Envelope beat;
    beat.mutable_heartbeat();
    host->send(beat);
    rig.cycle();  // heard
    rig.beating.clear();
  }
};

TEST_F(LostHost, SilentStopsWithinTheLease) {
  const Time lost = rig.now - rig.period();
  rig.cycles(150);
  expect_stops_and_holds(rig, lost, lease, way_rad(0.206));
}

TEST_F(LostHost, WhoseConnectionClosedStopsAtOnce) {
  const Time lost = rig.now;
  host->hang_up();
  rig.cycles(150);
  expect_stops_and_holds(rig, lost, 2 * rig.period(), way_rad(0.008));
}

TEST_F(LostHost, ThatDribblesBytesIsNoHostThatCommands) {
  const Time lost = rig.now - rig.period();
  std::string frame = wire::encode_frame(wire::FrameType::kLink, std::string(4000, 'x'));
  for (int i = 0; i < 150; ++i) {
    ::send(host->descriptor(), &frame[static_cast<std::size_t>(i)], 1, MSG_NOSIGNAL);
    rig.cycle();
  }
  expect_stops_and_holds(rig, lost, lease, way_rad(0.206));
}

TEST_F(LostHost, IsNotReplacedByAnObserversHeartbeats) {
  auto observer = rig.connect(wire::ROLE_OBSERVE);
  wire::Envelope beat;
  beat.mutable_heartbeat();
  host->send(beat);
  rig.cycle();
  const Time lost = rig.now - rig.period();
  rig.beating = {observer.get()};
  rig.cycles(150);
  expect_stops_and_holds(rig, lost, lease, way_rad(0.206));
}

/// The link's thread stands still: it takes no lease away. The cycle looks for itself.
TEST(LostLink, LetsTheLeaseRunOutInTheCycle) {
  FaultRig rig;
  ASSERT_TRUE(rig.start_moving());
  const Time lost = rig.now - rig.period();
  rig.has_commander = false;
  rig.cycles(150);
  expect_stops_and_holds(rig, lost, 206ms, way_rad(0.206));
}

}  // namespace
}  // namespace armsight::faults
