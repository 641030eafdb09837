// The bus model when things go wrong: error counters, bus-off and its restart, nobody who acknowledges, two voices
// under one identifier, and a gateway that loses, doubles, delays and changes frames.
#include <gtest/gtest.h>

#include "tools/sim/in_process_bus.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;

CanFrame frame_with(std::uint32_t id, std::uint8_t first = 0) { return {id, 8, {first}}; }

class BusErrors : public ::testing::Test {
 protected:
  InProcessBus bus;
  Time now{};
  BusEnd a{bus.model(), now}, b{bus.model(), now};

  void run(Duration span) {
    now += span;
    bus.model().run_until(now);
  }
  static int received(BusEnd& end, std::uint32_t id) {
    int count = 0;
    for (arm::BusFrame frame; end.receive(frame);) count += frame.frame.id == id && !frame.is_own_echo ? 1 : 0;
    return count;
  }
};

TEST_F(BusErrors, ADestroyedFrameIsSentAgainAndCounted) {
  int left = 3;
  bus.model().set_judge([&](const CanFrame&, Time) { return Passage{.is_destroyed = left-- > 0}; });
  a.send(frame_with(0x201));
  run(10ms);
  EXPECT_EQ(received(b, 0x201), 1);
  EXPECT_EQ(bus.model().error_frames(), 3U);
  EXPECT_EQ(bus.model().transmit_errors(a.port()), 3 * 8 - 1);
  EXPECT_EQ(bus.model().receive_errors(b.port()), 3 - 1);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kErrorActive);
  EXPECT_EQ(bus.model().busy_time(), 4 * 135us + 3 * 31us);
}

TEST_F(BusErrors, SixteenInARowMakePassiveThirtyTwoBusOffWhichEndsByItself) {
  int left = 16;
  bus.model().set_judge([&](const CanFrame&, Time) { return Passage{.is_destroyed = left-- > 0}; });
  a.send(frame_with(0x201));
  run(16 * 166us);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kErrorPassive);
  EXPECT_TRUE(a.take_errors().error_passive);
  run(10ms);
  EXPECT_EQ(received(b, 0x201), 1);
  left = 32;
  a.send(frame_with(0x202));
  a.send(frame_with(0x203));
  run(6ms);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kBusOff);
  EXPECT_TRUE(a.take_errors().bus_off);
  EXPECT_EQ(a.send(frame_with(0x204)), arm::SendResult::kQueueFull);
  left = 0;
  run(200ms);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kErrorActive);
  EXPECT_EQ(received(b, 0x202) + received(b, 0x203), 0) << "its queue is lost";
  a.send(frame_with(0x205));
  run(1ms);
  EXPECT_EQ(received(b, 0x205), 1);
}

TEST_F(BusErrors, WithoutAListenerASenderBecomesPassiveAndNeverBusOff) {
  bus.model().set_connected(a.port(), false);
  a.send(frame_with(0x201));
  run(500ms);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kErrorPassive);
  EXPECT_EQ(received(b, 0x201), 0);
  bus.model().set_connected(a.port(), true);
  run(1ms);
  EXPECT_EQ(received(b, 0x201), 1) << "what the queue held goes out";
}

TEST_F(BusErrors, OneIdentifierInTwoVoicesDestroysBothOneFrameOfTwoIsOne) {
  a.send(frame_with(0x182, 7));
  b.send(frame_with(0x182, 7));
  BusEnd c(bus.model(), now);
  run(1ms);
  EXPECT_EQ(received(c, 0x182), 1);
  a.send(frame_with(0x182, 7));
  b.send(frame_with(0x182, 8));
  run(10ms);
  EXPECT_EQ(received(c, 0x182), 0);
  EXPECT_EQ(bus.model().state(a.port()), PortState::kBusOff);
  EXPECT_EQ(bus.model().state(b.port()), PortState::kBusOff);
  EXPECT_EQ(bus.model().state(c.port()), PortState::kErrorActive);
}

TEST_F(BusErrors, AGatewayLosesDoublesDelaysAndChanges) {
  Passage passage;
  bus.model().set_judge([&](const CanFrame&, Time) { return passage; });
  const auto sent_and_received = [&] {
    a.send(frame_with(0x201, 1));
    run(1ms);
    return received(b, 0x201);
  };
  passage.is_lost = true;
  EXPECT_EQ(sent_and_received(), 0);
  EXPECT_EQ(a.take_errors().send_failures, 0U) << "its sender believes in it";
  passage = {.comes_twice = true};
  EXPECT_EQ(sent_and_received(), 2);
  passage = {.delay = 5ms};
  EXPECT_EQ(sent_and_received(), 0);
  run(6ms);
  EXPECT_EQ(received(b, 0x201), 1);
  passage = {.altered = frame_with(0x301, 2)};
  EXPECT_EQ(sent_and_received(), 0);
}

}  // namespace
}  // namespace armsight::sim
