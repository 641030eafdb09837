// Bits, loads and latest responses against figures worked out by hand, from controller.md §3.2 and from the literature.
#include "protocol/bus_budget.hpp"

#include <gtest/gtest.h>

#include <random>

#include "protocol/bus_traffic.hpp"

namespace armsight {
namespace {

using namespace std::chrono_literals;

RobotConfig six_nodes(double period_s = 0.004) {
  RobotConfig robot = load_robot(ARMSIGHT_ROBOT_FILE);
  robot.controller.period_s = period_s;
  return robot;
}

/// Five joints fewer two, and the hand.
RobotConfig three_nodes(double period_s) {
  RobotConfig robot = six_nodes(period_s);
  robot.drives.resize(2);
  return robot;
}

const BusMessage& message(const BusBudget& budget, const std::string& name) {
  for (const BusMessage& one : budget.messages)
    if (one.name == name) return one;
  throw std::out_of_range(name);
}

TEST(BusBudget, LongestFramesAreThoseOfTheLiterature) {
  const int expected[] = {55, 65, 75, 85, 95, 105, 115, 125, 135};  // 55 + 10 a byte
  for (int size = 0; size <= 8; ++size) EXPECT_EQ(worst_case_bits(size), expected[size]) << size;
}

// controller.md §3.2, arbitration at 1 Mbit/s, data at 5: 8 bytes 56.6 us, 12 64.6, 16 72.6.
TEST(BusBudget, LongestFdFramesAreThoseOfTheTable) {
  const BusRates rates{1e6, 5e6};
  EXPECT_NEAR(1e6 * worst_case_s(8, true, rates), 56.6, 1e-9);
  EXPECT_NEAR(1e6 * worst_case_s(12, true, rates), 64.6, 1e-9);
  EXPECT_NEAR(1e6 * worst_case_s(16, true, rates), 72.6, 1e-9);
  EXPECT_NEAR(1e6 * worst_case_s(8, false, rates), 135.0, 1e-9);
}

// Drawn bit by bit with a program of its own: head, data, CRC 0x4599, the other bit after every five equal ones.
TEST(BusBudget, StuffingIsCountedBitByBit) {
  const auto bits = [](std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    CanFrame frame;
    frame.id = id;
    for (const std::uint8_t byte : data) frame.data[frame.size++] = byte;
    return stuffed_bits(frame);
  };
  EXPECT_EQ(bits(0x080, {}), 51) << "the SYNC that controller.md §3.2 found on a recorded bus";
  EXPECT_EQ(bits(0x080, {1}), 59);
  EXPECT_EQ(bits(0x77F, {5}), 59);
  EXPECT_EQ(bits(0x000, {0, 0, 0, 0, 0, 0, 0, 0}), 127);
  EXPECT_EQ(bits(0x7FF, {255, 255, 255, 255, 255, 255, 255, 255}), 126);
  EXPECT_EQ(bits(0x555, {0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA}), 112);
  EXPECT_EQ(bits(0x181, {0x37, 0x16, 0x39, 0x30, 0x00, 0x00, 0x9C, 0xFF}), 118);
}

TEST(BusBudget, NoFrameIsLongerThanItsWorstCase) {
  std::mt19937 random(1);
  int most = 0;
  for (int i = 0; i < 20'000; ++i) {
    CanFrame frame;
    frame.id = random() & 0x7FF;
    frame.size = static_cast<std::uint8_t>(random() % 9);
    const bool is_noise = i % 2 == 0;
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(is_noise ? random() : random() % 2 * 0xFF);
    const int bits = stuffed_bits(frame);
    ASSERT_LE(bits, worst_case_bits(frame.size));
    ASSERT_GE(bits, 47 + 8 * frame.size);
    most = std::max(most, bits);
  }
  EXPECT_GE(most, 124);
}

// A cycle: SYNC 65 + 6 · (135 + 135) = 1685 bits. A second: 7 heartbeats · 10 · 65 + 20 SDO · 2 · 135 + 5 EMCY · 135 =
// 4550 + 5400 + 675 = 10 625 bits.
TEST(BusBudget, SixNodesOnOneBus) {
  const auto load = [](double period_s) { return highest_load(bus_budgets(six_nodes(period_s))); };
  EXPECT_NEAR(load(0.004), (250 * 1685 + 10625) / 1e6, 1e-12);
  EXPECT_NEAR(load(0.002), 0.853125, 1e-12);
  EXPECT_NEAR(load(0.001), 1.695625, 1e-12);
  const std::vector<BusBudget> budgets = bus_budgets(six_nodes());
  ASSERT_EQ(budgets.size(), 1u);
  EXPECT_EQ(budgets[0].node_count, 6);
  EXPECT_NEAR(budgets[0].cycle_s, 1685e-6, 1e-12);
}

TEST(BusBudget, TheBitRateCounts) {
  RobotConfig robot = six_nodes();
  robot.controller.bus_bitrate_bit_s = 500'000;
  EXPECT_NEAR(highest_load(bus_budgets(robot)), 2 * 0.431875, 1e-12);
}

// The example with which Davis et al. (2007) refuted the older analysis: the second instance is later than the first.
TEST(BusBudget, LatestResponseOfALaterInstance) {
  std::vector<BusMessage> abc(3);
  for (BusMessage& m : abc) m.wire_s = 1.0;
  abc[0].period_s = 2.5;
  abc[1].period_s = abc[2].period_s = 3.5;
  EXPECT_NEAR(*latest_response_s(abc, 0, 0.008), 2.0, 1e-9);
  EXPECT_NEAR(*latest_response_s(abc, 1, 0.008), 3.0, 1e-9);
  EXPECT_NEAR(*latest_response_s(abc, 2, 0.008), 3.5, 1e-9);
}

TEST(BusBudget, LatestResponsesOfTheArm) {
  const BusBudget budget = bus_budgets(six_nodes()).front();
  const auto latest_us = [&](const std::string& name) { return 1e6 * *message(budget, name).latest_s; };
  EXPECT_NEAR(latest_us("SYNC"), 135 + 65, 1e-6) << "a frame on the wire is not interrupted";
  EXPECT_NEAR(latest_us("TPDO1 of node 1"), 135 + 65 + 135 + 135, 1e-6) << "blocked, SYNC, an EMCY, itself";
  EXPECT_NEAR(latest_us("RPDO1 of node 6"), 135 + 135 + 1685, 1e-6) << "blocked, an EMCY, the cycle";
  // Nothing blocks the last.
  EXPECT_NEAR(latest_us("heartbeat of the controller"), 1685 + 135 + 2 * 135 + 7 * 65, 1e-6);
}

TEST(BusBudget, AnOverloadedBusHasNoLatestResponse) {
  const BusBudget budget = bus_budgets(six_nodes(0.001)).front();
  EXPECT_NEAR(1e6 * *message(budget, "TPDO1 of node 6").latest_s, 135 + 65 + 135 + 5 * 135 + 65 + 5 * 135 + 135, 1e-6)
      << "all that goes before it goes a second time, since it takes longer than a cycle";
  EXPECT_FALSE(message(budget, "RPDO1 of node 6").latest_s);
}

TEST(BusBudget, NamesTheRateThatFitsAndTheBusesThatARateNeeds) {
  EXPECT_EQ(broken_load_rule(six_nodes(0.004)), "");
  EXPECT_EQ(broken_load_rule(six_nodes(0.002)), "");
  EXPECT_EQ(broken_load_rule(six_nodes(0.001)),
            "bus 0 with 6 nodes would be loaded to 169.6 %, above 90 % (controller.bus_load_limit); the highest rate "
            "that fits is 526.3 Hz (period_s 0.0019); this rate needs 2 buses");
  EXPECT_NEAR(*shortest_period_s(six_nodes()), 0.0019, 1e-12) << "1685 bits in 1.9 ms and 1.1 %: 89.7 %";
  EXPECT_EQ(buses_needed(six_nodes(), 0.002), 1);
  EXPECT_EQ(buses_needed(six_nodes(), 0.001), 2);
  // Three nodes at 1 kHz: 1000 · (65 + 3 · 270) + 4 · 650 + 5400 + 675.
  EXPECT_NEAR(highest_load(bus_budgets(three_nodes(0.001))), 0.883675, 1e-12);
}

/// Six motors and no other traffic, as the table has it; the hand stays a CANopen node.
RobotConfig damiao_nodes(bool is_fd) {
  RobotConfig robot = six_nodes(0.001);
  for (DriveConfig& drive : robot.drives) {
    drive.family = DriveFamily::kDamiao;
    drive.mit.reply_id = static_cast<std::uint8_t>(0x10 + drive.node);
    drive.mit.is_fd = is_fd;
  }
  return robot;
}

// Five motors: 5 · (135 + 135) us classic, 5 · 2 · 56.6 us FD; the hand: SYNC 65, 135 + 135; both families' background.
TEST(BusBudget, DamiaoDrivesClassicAndFd) {
  const double hand = 1000 * (65 + 270) + 2 * 650 + 5400 + 675;
  EXPECT_NEAR(highest_load(bus_budgets(damiao_nodes(false))), 1e-6 * (1000 * 5 * 270 + 20 * 270 + hand), 1e-9);
  EXPECT_NEAR(highest_load(bus_budgets(damiao_nodes(true))), 1e-6 * (1000 * 10 * 56.6 + 40 * 56.6 + hand), 1e-9);
}

TEST(BusBudget, TheLimitIsTheRobotFiles) {
  RobotConfig robot = six_nodes(0.002);
  robot.controller.bus_load_limit = 0.8;
  EXPECT_NE(broken_load_rule(robot).find("loaded to 85.3 %, above 80 %"), std::string::npos);
  EXPECT_NEAR(*shortest_period_s(robot), 0.0022, 1e-12);
  robot.controller.bus_load_limit = 0.01;
  EXPECT_NE(broken_load_rule(robot).find("no rate fits"), std::string::npos);
  EXPECT_FALSE(buses_needed(robot, 0.002));
}

// One cycle of 4 ms, three times: SYNC ends after 59 us, an answer 118 us later.
TEST(BusTraffic, CountsWhatWasThere) {
  BusTraffic traffic(BusRates{});
  for (int k = 0; k <= 250; ++k) {
    const Time begin = time_from_ns(4'000'000 * k);
    traffic.add(encode(Sync{1}), begin + 59us);
    if (k < 250) traffic.add(encode(Tpdo1{0x1637, 0x3039, -100}, 1), begin + 177us);
  }
  EXPECT_NEAR(traffic.duration_s(), 1.0, 1e-9);
  EXPECT_EQ(traffic.messages().at(0x080).count, 250u) << "the first frame opens the time that is looked at";
  EXPECT_EQ(traffic.messages().at(0x181).count, 250u);
  EXPECT_NEAR(traffic.load(), 250 * (59 + 118) * 1e-6, 1e-9);
  EXPECT_NEAR(traffic.worst_case_load(), 250 * (65 + 135) * 1e-6, 1e-9);
  EXPECT_NEAR(traffic.highest_load(), 25 * (59 + 118) * 1e-5, 1e-9);
  EXPECT_NEAR(*traffic.messages().at(0x181).latest_s, 118e-6 + 65e-6, 2e-9) << "after the SYNC began";
}

}  // namespace
}  // namespace armsight
