// Lockstep: a message sent in cycle k acts in cycle k+1, whatever the machine does meanwhile.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "protocol/transport/framed_stream.hpp"
#include "protocol/transport/sim_clock.hpp"
#include "tools/sim/sim_clock_server.hpp"
#include "tools/temporary_folder.hpp"

namespace armsight {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 4ms;
constexpr int kController = 1, kHost = 2;
const net::StreamOptions kLink{wire::FrameType::kLink, wire::kMaxFromController, wire::kMaxFromController, 1 << 20};

/// arm_sim's part: nothing but time.
class TimeServer {
 public:
  explicit TimeServer(const std::string& path, std::uint64_t seed = 7)
      : server_({path, true, kPeriod, seed},
                {[this] { return ++drifts_, std::string(); }, [](const std::string& file) {
                   return file.empty() ? std::string("no file named") : std::string();
                 }}),
        thread_([this](const std::stop_token& stop) {
          while (server_.run_participants([&stop] { return stop.stop_requested(); })) {
            ++cycles_;
            server_.end_cycle();
          }
        }) {}
  std::uint64_t cycles() const { return cycles_; }
  int drifts() const { return drifts_; }
  /// Waits until so many have joined: time stands for them until everybody before them is done.
  void await_joined(std::size_t count) const {
    while (server_.ever_joined() < count) std::this_thread::sleep_for(1ms);
  }
  void await_cycles(std::uint64_t count) const {
    while (cycles_ < count) std::this_thread::sleep_for(1ms);
  }

 private:
  std::atomic<std::uint64_t> cycles_ = 0;
  std::atomic<int> drifts_ = 0;
  sim::SimClockServer server_;
  std::jthread thread_;
};

void sleep_at_random(std::mt19937& random) {
  if (random() % 4 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 800));
}

std::uint32_t id_in(std::string_view payload) { return static_cast<std::uint32_t>(payload[0]); }

/// Two programs that answer each other; every sleep differs from run to run, the log must not.
std::string exchange(unsigned sleep_seed, std::uint64_t seed) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"), seed);
  const auto conductor = net::join_as_conductor(folder.file("clock"), "test", kPeriod);
  std::string controller_log, host_log;
  std::atomic<int> port = 0;
  std::jthread controller([&] {
    std::mt19937 random(sleep_seed);
    const auto clock = net::join_sim_clock(folder.file("clock"), "controller", kController, kPeriod);
    net::StreamServer server("127.0.0.1:0", net::ChannelKind::kLink, kLink, *clock, id_in);
    port = server.port();
    for (int cycle = 0; cycle < 60; ++cycle) {
      sleep_at_random(random);
      for (const auto& event : server.receive()) {
        if (event.is_closed) continue;
        controller_log += std::to_string(to_ns(clock->now())) + " " + event.message.payload.substr(1) + " " +
                          std::to_string(to_ns(event.message.arrival)) + "\n";
        event.stream->send("re " + event.message.payload.substr(1));
      }
      clock->wait_next_cycle();
    }
  });
  time.await_joined(2);
  conductor->wait_next_cycle();
  while (port == 0) std::this_thread::sleep_for(1ms);
  std::jthread host([&] {
    std::mt19937 random(sleep_seed + 1);
    const auto clock = net::join_sim_clock(folder.file("clock"), "host", kHost, kPeriod);
    auto link = net::connect_tcp("127.0.0.1:" + std::to_string(port), kLink, *clock, 5s);
    link->set_channel({net::ChannelKind::kLink, clock->arm_controller()});
    const std::string me(1, static_cast<char>(clock->participant()));
    for (int cycle = 0; cycle < 40; ++cycle) {
      sleep_at_random(random);
      for (const auto& message : link->receive())
        host_log += std::to_string(to_ns(clock->now())) + " " + message.payload + " " +
                    std::to_string(to_ns(message.arrival)) + "\n";
      link->send(me + "n" + std::to_string(cycle));
      if (cycle % 3 == 0) link->send(me + std::string(20'000, 'x') + std::to_string(cycle));
      clock->wait_next_cycle();
    }
  });
  time.await_joined(3);
  for (int i = 0; i < 80; ++i) conductor->wait_next_cycle();
  controller.join();
  host.join();
  return controller_log + "--\n" + host_log;
}

TEST(Lockstep, GivesTheSameRunWhateverTheMachineDoes) {
  const std::string once = exchange(1, 7);
  EXPECT_GT(std::count(once.begin(), once.end(), '\n'), 90);
  EXPECT_EQ(once, exchange(99, 7));
  EXPECT_NE(once, exchange(1, 8)) << "the seed sets crystals and delays";
}

TEST(Lockstep, MessagesActInTheNextCycleWithArrivalsInsideTheOneBefore) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"));
  const auto a = net::join_sim_clock(folder.file("clock"), "a", kController, kPeriod);
  std::unique_ptr<net::Clock> b;
  std::jthread joining([&] { b = net::join_sim_clock(folder.file("clock"), "b", kHost, kPeriod); });
  time.await_joined(2);
  a->wait_next_cycle();
  joining.join();
  a->count_sent({net::ChannelKind::kLink, b->participant()});
  EXPECT_TRUE(b->due_channels(net::ChannelKind::kLink).empty());
  const Time before = b->now();
  std::jthread stepping([&] { a->wait_next_cycle(); });
  b->wait_next_cycle();
  stepping.join();
  const auto due = b->due({net::ChannelKind::kLink, a->participant()});
  ASSERT_EQ(due.size(), 1u);
  EXPECT_GE(due[0] - before, 49us);
  EXPECT_LT(due[0], b->now());
}

TEST(Lockstep, DropsAParticipantWhoseConnectionBreaks) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"));
  const auto a = net::join_sim_clock(folder.file("clock"), "a", kHost, kPeriod);
  auto clock = net::make_monotonic_clock(1ms);
  const net::StreamOptions options{wire::FrameType::kSimClock, wire::kMaxSimClock, wire::kMaxSimClock, 1 << 20};
  auto raw = net::connect_unix(folder.file("clock"), options, *clock);
  raw->send(std::string("\x0a\x05\x0a\x01x\x10\x02", 7));  // Join{name: "x", role: host}
  time.await_joined(2);
  a->wait_next_cycle();  // the silent one takes part from here on
  std::atomic<bool> is_granted = false;
  std::jthread waiting([&] {
    a->wait_next_cycle();
    is_granted = true;
  });
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(is_granted) << "it never says Done";
  raw->close("killed");
  waiting.join();
  EXPECT_TRUE(is_granted);
}

TEST(Lockstep, TimeStandsWhileNobodyTakesPart) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"));
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(time.cycles(), 0u);
  {
    const auto a = net::join_sim_clock(folder.file("clock"), "a", kHost, kPeriod);
    for (int i = 0; i < 5; ++i) a->wait_next_cycle();
  }
  time.await_cycles(6);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(time.cycles(), 6u) << "five cycles and the one it left in";
}

TEST(Lockstep, TakesTheConductorsWishes) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"));
  const auto conductor = net::join_as_conductor(folder.file("clock"), "demo", kPeriod);
  conductor->inject_drift();
  EXPECT_EQ(time.drifts(), 1);
  EXPECT_THROW(conductor->finish(""), std::runtime_error);
  EXPECT_NO_THROW(conductor->finish("truth.json"));
}

TEST(Lockstep, RefusesAControllerOfAnotherRate) {
  TemporaryFolder folder;
  TimeServer time(folder.file("clock"));
  EXPECT_THROW(net::join_sim_clock(folder.file("clock"), "c", kController, 2ms), std::runtime_error);
  EXPECT_THROW(net::join_sim_clock(folder.file("nobody"), "c", kController, kPeriod), std::runtime_error);
}

TEST(Crystals, StayWithinTheirBoundsAndDependOnTheSeedOnly) {
  for (std::uint64_t seed = 1; seed < 200; ++seed) {
    const net::Crystal crystal = sim::make_crystal(seed, 2, false);
    EXPECT_LE(std::abs(crystal.offset_ns), 1'000'000'000);
    EXPECT_LE(std::abs(crystal.skew_ppb), 50'000);
    EXPECT_EQ(crystal.to_monotonic_ns(crystal.to_own_ns(123'456'789'012)), 123'456'789'012);
  }
  EXPECT_EQ(sim::make_crystal(3, 2, false).offset_ns, sim::make_crystal(3, 2, false).offset_ns);
  EXPECT_NE(sim::make_crystal(3, 1, false).offset_ns, sim::make_crystal(3, 2, false).offset_ns);
  EXPECT_EQ(sim::make_crystal(3, 1, true).offset_ns, 0);
}

}  // namespace
}  // namespace armsight
