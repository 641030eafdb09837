// The simulated camera's stream over TCP, through the host's own camera: what is asked for comes, stamped and late.
#include "tools/sim/camera_server.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "host/camera.hpp"
#include "protocol/camera_stream.pb.h"
#include "tests/sim/stage_world.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kCycle_ns = 4'000'000;
constexpr std::int64_t kOffset_ns = 123'456'789;  // client's clock beside simulated time

/// A camera whose simulated time passes only when the test turns it, one cycle a turn.
struct CameraServerTest : ::testing::Test {
  RobotConfig robot = test::default_robot();
  std::unique_ptr<net::Clock> clock = net::make_monotonic_clock(1ms);
  CameraServer server{"127.0.0.1:0",
                      *clock,
                      test::default_scene(),
                      robot.hand_marker,
                      noise_figures(NoiseSet::kNominal),
                      3,
                      [](std::uint32_t, std::int64_t sim_ns) { return sim_ns + kOffset_ns; }};
  WorldView world = test::world_with_marker(robot, test::marker_pose(0, 0, 0.3, 0.5, 0, 0));
  std::int64_t now_ns = 0;

  void turn() {
    now_ns += kCycle_ns;
    server.advance(now_ns, [this](double) { return world; });
  }
  /// The server must answer while the client waits for its announcement.
  std::unique_ptr<host::Camera> connect() {
    std::atomic<bool> is_done = false;
    std::jthread serving([&] {
      while (!is_done) {
        server.advance(now_ns, [this](double) { return world; });
        std::this_thread::yield();
      }
    });
    auto camera = host::make_camera("sim:127.0.0.1:" + std::to_string(server.port()), {}, *clock);
    is_done = true;
    return camera;
  }
};

TEST_F(CameraServerTest, AnnouncesNominalIntrinsics) {
  const auto camera = connect();
  const host::Intrinsics nominal = test::default_scene().camera.intrinsics;
  EXPECT_EQ(camera->intrinsics().width, 1280);
  EXPECT_EQ(camera->intrinsics().fx, nominal.fx);
  EXPECT_EQ(camera->intrinsics().plumb_bob, nominal.plumb_bob);
}

TEST_F(CameraServerTest, SendsWhatIsAskedForStampedInTheClientsClock) {
  const auto camera = connect();
  for (int i = 0; i < 50; ++i) turn();
  EXPECT_EQ(server.rendered(), 0U);  // nobody asked
  const std::int64_t asked_ns = now_ns;
  camera->request(3);
  std::vector<host::Frame> frames;
  std::vector<std::int64_t> came_ns;
  for (int i = 0; i < 400 && now_ns < asked_ns + 1'000'000'000; ++i) {
    turn();
    if (server.rendered() == 0) std::this_thread::sleep_for(1ms);  // the request crosses the loopback
    while (auto frame = camera->poll()) {
      frames.push_back(*frame);
      came_ns.push_back(now_ns);
    }
  }
  for (int i = 0; i < 200 && frames.size() < 3; ++i) {
    std::this_thread::sleep_for(1ms);
    if (auto frame = camera->poll()) frames.push_back(*frame);
  }
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(server.rendered(), 3U);
  const std::int64_t period_ns = static_cast<std::int64_t>(1e9 / 30.0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].gray_or_bgr.size(), cv::Size(1280, 720));
    const std::int64_t middle_ns = to_ns(frames[i].capture_time) - kOffset_ns;
    EXPECT_EQ(middle_ns, static_cast<std::int64_t>(frames[i].number) * period_ns + 4'000'000);
    EXPECT_GE(middle_ns, asked_ns);
    EXPECT_EQ(frames[i].number, frames[0].number + i);
  }
}

TEST_F(CameraServerTest, LatencyIsTwentyMillisecondsGiveOrTakeFive) {
  const auto camera = connect();
  camera->request(40);
  std::uint64_t drawn = 0;
  std::vector<double> latency_ms;
  std::vector<Time> stamps;
  for (int i = 0; i < 2000 && latency_ms.size() < 40; ++i) {
    turn();
    if (drawn == 0) std::this_thread::sleep_for(1ms);
    drawn = server.rendered();
    if (drawn == 0) continue;
    for (int wait = 0; wait < 3; ++wait) {  // what was sent this turn is here at once or in a moment
      while (auto frame = camera->poll())
        latency_ms.push_back(static_cast<double>(now_ns + kOffset_ns - to_ns(frame->capture_time)) * 1e-6);
      std::this_thread::sleep_for(200us);
    }
  }
  ASSERT_EQ(latency_ms.size(), 40U);
  const auto [least, most] = std::minmax_element(latency_ms.begin(), latency_ms.end());
  EXPECT_GE(*least, 15.0 - 1e-6);
  EXPECT_LE(*most, 25.0 + 4.0 + 4.0);  // a cycle of rounding, and one for a loaded machine
  EXPECT_GT(*most - *least, 4.0);
}

TEST_F(CameraServerTest, ANewRequestReplacesTheOldOne) {
  const auto camera = connect();
  camera->request(1000);
  std::this_thread::sleep_for(20ms);
  turn();
  camera->request(0);
  std::this_thread::sleep_for(20ms);
  turn();
  const std::uint64_t drawn = server.rendered();
  for (int i = 0; i < 100; ++i) turn();
  EXPECT_LE(server.rendered(), drawn + 1);
}

TEST_F(CameraServerTest, ClosesOnWhatIsNoCameraMessage) {
  net::StreamOptions options;
  options.type = wire::FrameType::kCamera;
  const auto stream = net::connect_tcp("127.0.0.1:" + std::to_string(server.port()), options, *clock, 5s);
  stream->send("\xff\xff\xff garbage");
  for (int i = 0; i < 1000 && stream->is_open(); ++i) {
    turn();
    stream->receive();
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_FALSE(stream->is_open());
  EXPECT_NO_THROW(connect());  // the server lives on
}

}  // namespace
}  // namespace armsight::sim
