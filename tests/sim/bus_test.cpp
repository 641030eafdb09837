// The emulated bus: who wins, how long a frame takes, what fits, and the socket that programs join by.
#include <gtest/gtest.h>

#include <fstream>

#include "arm_controller/emulated_bus.hpp"
#include "tools/sim/bus_hub.hpp"
#include "tools/sim/bus_log.hpp"
#include "tools/sim/in_process_bus.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight::sim {
namespace {

using namespace std::chrono_literals;

CanFrame frame_of(std::uint32_t id, std::uint8_t size = 8) {
  CanFrame frame;
  frame.id = id;
  frame.size = size;
  return frame;
}

std::vector<arm::BusFrame> all(arm::CanBus& bus) {
  std::vector<arm::BusFrame> frames;
  arm::BusFrame frame;
  while (bus.receive(frame)) frames.push_back(frame);
  return frames;
}

TEST(Bus, TheLowestIdentifierWinsAndFramesTakeTheirTime) {
  InProcessBus bus;
  const auto a = bus.join(), b = bus.join();
  a->send(frame_of(0x201));
  b->send(frame_of(0x181));
  bus.advance_to(time_from_ns(1'000'000));
  const auto seen = all(*a);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].frame.id, 0x181u);
  EXPECT_EQ(to_ns(seen[0].time), 135'000) << "8 bytes at 1 Mbit/s, worst case";
  EXPECT_EQ(to_ns(seen[1].time), 270'000);
  EXPECT_FALSE(seen[0].is_own_echo);
  EXPECT_TRUE(seen[1].is_own_echo);
}

TEST(Bus, MailboxesSendByPriorityAndASocketAsQueued) {
  using enum BusModel::Order;
  for (const BusModel::Order order : {kByPriority, kAsQueued}) {
    BusModel bus(1e6);
    std::vector<std::uint32_t> ends;
    const int port = bus.add_port([&](const CanFrame& frame, Time, bool) { ends.push_back(frame.id); }, order);
    const int other = bus.add_port([](const CanFrame&, Time, bool) {});
    bus.send(other, frame_of(0x080), Time{});
    for (const std::uint32_t id : {0x706u, 0x186u}) bus.send(port, frame_of(id), Time{});
    bus.send(other, frame_of(0x206), Time{});
    bus.run_until(time_from_ns(1'000'000));
    const std::vector<std::uint32_t> by_priority{0x080, 0x186, 0x206, 0x706}, as_queued{0x080, 0x206, 0x706, 0x186};
    EXPECT_EQ(ends, order == kByPriority ? by_priority : as_queued) << "does the sample wait behind the heartbeat?";
  }
}

TEST(Bus, AFrameOnTheWireIsNotInterrupted) {
  InProcessBus bus;
  const auto a = bus.join(), b = bus.join();
  a->send(frame_of(0x700));
  bus.advance_to(time_from_ns(10'000));
  b->send(frame_of(0x080, 1));
  bus.advance_to(time_from_ns(1'000'000));
  const auto seen = all(*a);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].frame.id, 0x700u);
  EXPECT_EQ(to_ns(seen[1].time), 135'000 + 65'000);
}

TEST(Bus, AFullQueueDropsAndSaysSo) {
  InProcessBus bus(1e6, 3);
  const auto a = bus.join();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(a->send(frame_of(0x201)), arm::SendResult::kSent);
  EXPECT_EQ(a->send(frame_of(0x201)), arm::SendResult::kQueueFull);
  EXPECT_EQ(a->take_errors().send_failures, 1u);
  EXPECT_EQ(a->take_errors().send_failures, 0u);
}

/// SYNC, six set-points and six answers a cycle: what is the longest delay of the last answer, and what was dropped?
struct CycleLoad {
  Duration last_answer{0};
  std::uint64_t dropped = 0;
};
CycleLoad run_cycles(Duration period, int cycles) {
  BusModel bus(1e6);
  std::vector<int> nodes;
  CycleLoad load;
  Time cycle_start{};
  const int controller = bus.add_port([&](const CanFrame& frame, Time end, bool) {
    if (frame.id > 0x180 && frame.id <= 0x186) load.last_answer = std::max(load.last_answer, end - cycle_start);
  });
  for (std::uint32_t node = 1; node <= 6; ++node)
    nodes.push_back(bus.add_port([&bus, &nodes, node](const CanFrame& frame, Time end, bool) {
      if (frame.id == kSyncId) bus.send(nodes[node - 1], frame_of(0x180 + node), end);
    }));
  for (int i = 0; i < cycles; ++i) {
    cycle_start = time_from_ns(i * period.count());
    bus.send(controller, frame_of(kSyncId, 1), cycle_start);
    for (std::uint32_t node = 1; node <= 6; ++node) bus.send(controller, frame_of(0x200 + node), cycle_start);
    bus.run_until(cycle_start + period);
  }
  load.dropped = bus.dropped();
  return load;
}

TEST(Bus, CarriesSixNodesAt250And500HzAndFailsAt1000) {
  EXPECT_LT(run_cycles(4ms, 500).last_answer, 4ms);
  EXPECT_EQ(run_cycles(4ms, 500).dropped, 0u);
  EXPECT_LT(run_cycles(2ms, 500).last_answer, 2ms);
  EXPECT_EQ(run_cycles(2ms, 500).dropped, 0u);
  const CycleLoad overloaded = run_cycles(1ms, 500);
  EXPECT_GT(overloaded.dropped, 100u);
}

TEST(BusHub, JoinsProgramsAndObserversAtRealPace) {
  TemporaryFolder folder;
  BusModel bus(1e6);
  ServerClock clock(false);
  BusHub hub(folder.file("bus"), bus, clock, [](std::uint32_t, std::int64_t ns) { return ns; });
  const auto own = net::make_monotonic_clock(1ms);
  const auto program = arm::join_emulated_bus(folder.file("bus"), *own);
  arm::BusObserver observer(folder.file("bus"));
  hub.receive();
  const int node = bus.add_port([](const CanFrame&, Time, bool) {});
  EXPECT_EQ(program->send(frame_of(kSyncId, 1)), arm::SendResult::kSent);
  hub.receive();
  bus.send(node, frame_of(0x181), clock.now());
  bus.run_until(clock.now() + 10ms);
  const auto seen = all(*program);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_TRUE(seen[0].is_own_echo);
  EXPECT_EQ(seen[1].frame.id, 0x181u);
  EXPECT_LT(seen[0].time, seen[1].time);
  arm::BusFrame frame;
  ASSERT_TRUE(observer.receive(frame, 100ms));
  EXPECT_EQ(frame.frame.id, kSyncId);
}

TEST(BusHub, TellsTheSenderWhoseQueueIsFull) {
  TemporaryFolder folder;
  BusModel bus(1e6, 2);
  ServerClock clock(false);
  BusHub hub(folder.file("bus"), bus, clock, [](std::uint32_t, std::int64_t ns) { return ns; });
  const auto own = net::make_monotonic_clock(1ms);
  const auto program = arm::join_emulated_bus(folder.file("bus"), *own);
  for (int i = 0; i < 5; ++i) program->send(frame_of(0x201));
  hub.receive();  // joins
  hub.receive();
  all(*program);
  EXPECT_EQ(program->take_errors().send_failures, 3u);
}

TEST(BusHub, AProgramLosesTheBusWithItsHub) {
  TemporaryFolder folder;
  BusModel bus(1e6);
  ServerClock clock(false);
  auto hub =
      std::make_unique<BusHub>(folder.file("bus"), bus, clock, [](std::uint32_t, std::int64_t ns) { return ns; });
  const auto own = net::make_monotonic_clock(1ms);
  const auto program = arm::join_emulated_bus(folder.file("bus"), *own);
  hub->receive();
  hub.reset();
  arm::BusFrame frame;
  EXPECT_FALSE(program->receive(frame));
  EXPECT_TRUE(program->take_errors().lost);
  EXPECT_EQ(program->send(frame_of(0x201)), arm::SendResult::kBusDown);
  EXPECT_THROW(arm::join_emulated_bus(folder.file("bus"), *own), std::runtime_error);
}

TEST(BusLog, HoldsEveryFrameInOrderAfterFlushAndAfterTheEnd) {
  constexpr std::uint32_t kFrames = 5000;
  const TemporaryFolder folder;
  const auto frames_in_file = [&folder] {
    std::ifstream in(folder.file("bus.log"));
    std::uint32_t count = 0;
    for (std::string text; std::getline(in, text); ++count) {
      const auto line = parse_candump(text).line;
      if (!line || line->frame.id != count % 0x700) ADD_FAILURE() << "line " << count << ": " << text;
    }
    return count;
  };
  {
    BusLog log(folder.file("bus.log"));
    for (std::uint32_t i = 0; i < kFrames; ++i)
      log.add({time_from_ns(1'000'000 * i), "emulated", frame_of(i % 0x700), false});
    log.flush();
    EXPECT_EQ(frames_in_file(), kFrames);
    log.add({time_from_ns(1'000'000LL * kFrames), "emulated", frame_of(kFrames % 0x700), false});
  }
  EXPECT_EQ(frames_in_file(), kFrames + 1);
}

TEST(BusLog, SaysWhatItCannotWrite) {
  EXPECT_THROW(BusLog("/no such folder/bus.log"), std::runtime_error);
  BusLog full("/dev/full");
  full.add({time_from_ns(0), "emulated", frame_of(1), false});
  EXPECT_THROW(full.flush(), std::runtime_error);
}

}  // namespace
}  // namespace armsight::sim
