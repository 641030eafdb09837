// The clocks of host and arm: does the stated bound hold, whatever the link does?
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/clock_alignment.hpp"

namespace armsight::host {
namespace {

// Two clocks and a link between them; truth is known here alone.
struct Clocks {
  double offset_s;
  double skew;
  std::mt19937_64 random{7};
  double now_s = 3.0;

  Time arm(double host_s) const { return time_from_ns(std::llround((host_s + offset_s + skew * host_s) * 1e9)); }
  static Time host(double host_s) { return time_from_ns(std::llround(host_s * 1e9)); }

  ClockExchange exchange(double out_min, double out_jitter, double back_min, double back_jitter) {
    std::exponential_distribution<double> jitter(1.0);
    const double received = now_s + out_min + out_jitter * jitter(random);
    const double answered = received + 0.004;
    const double returned = answered + back_min + back_jitter * jitter(random);
    const ClockExchange e{host(now_s), arm(received), arm(answered), host(returned)};
    now_s += 0.05;
    return e;
  }
  double error_ms(const ClockAlignment& alignment, double at_s) const {
    return to_seconds(alignment.to_arm(host(at_s))->arm_time - arm(at_s)) * 1e3;
  }
};

TEST(ClockAlignment, KnowsNothingBeforeTheFirstExchange) {
  const ClockAlignment alignment;
  EXPECT_FALSE(alignment.to_arm(time_from_ns(5)).has_value());
  EXPECT_FALSE(alignment.bound().has_value());
}

TEST(ClockAlignment, FindsOffsetAndSkewOnASymmetricLink) {
  for (const double skew : {-50e-6, -20e-6, 20e-6, 50e-6}) {
    Clocks clocks{-0.83, skew};
    ClockAlignment alignment;
    for (int i = 0; i < 256; ++i) alignment.add(clocks.exchange(0.0001, 0.0002, 0.0001, 0.0002));
    EXPECT_NEAR(alignment.skew(), skew, 15e-6);
    EXPECT_LT(std::abs(clocks.error_ms(alignment, clocks.now_s)), 0.05);
    EXPECT_LT(to_seconds(*alignment.bound()) * 1e3, 0.6);
  }
}

TEST(ClockAlignment, BoundHoldsOnJitteredAndAsymmetricLinks) {
  const double links[][4] = {
      {5e-5, 1e-3, 5e-5, 1e-3}, {5e-5, 3e-3, 5e-5, 1e-4}, {2e-3, 1e-3, 1e-4, 1e-3}, {1e-4, 5e-3, 4e-3, 5e-3}};
  for (const auto& link : links) {
    for (const double skew : {-100e-6, -50e-6, 0.0, 35e-6, 100e-6}) {
      Clocks clocks{0.41, skew};
      ClockAlignment alignment;
      for (int i = 0; i < 400; ++i) {
        alignment.add(clocks.exchange(link[0], link[1], link[2], link[3]));
        for (const double ago_s : {0.0, 0.5, -0.2}) {
          const double at_s = clocks.now_s - ago_s;
          const double bound_ms = to_seconds(alignment.to_arm(Clocks::host(at_s))->bound) * 1e3;
          ASSERT_LE(std::abs(clocks.error_ms(alignment, at_s)), bound_ms + 1e-6)
              << "exchange " << i << " skew " << skew;
        }
      }
    }
  }
}

TEST(ClockAlignment, ConvergesBelowTwoMillisecondsOnTheSimulatedLink) {
  Clocks clocks{0.97, 50e-6};
  ClockAlignment alignment;
  std::uniform_real_distribution<double> delay(0.05e-3, 3e-3);
  for (int i = 0; i < 40; ++i) alignment.add(clocks.exchange(delay(clocks.random), 0, delay(clocks.random), 0));
  EXPECT_LT(to_seconds(*alignment.bound()), 0.002);
}

TEST(ClockAlignment, StartsAgainAfterAStep) {
  Clocks clocks{0.2, 10e-6};
  ClockAlignment alignment;
  for (int i = 0; i < 100; ++i) alignment.add(clocks.exchange(1e-4, 1e-4, 1e-4, 1e-4));
  clocks.offset_s += 0.5;
  for (int i = 0; i < 30; ++i) alignment.add(clocks.exchange(1e-4, 1e-4, 1e-4, 1e-4));
  EXPECT_EQ(alignment.steps(), 1);
  EXPECT_LT(std::abs(clocks.error_ms(alignment, clocks.now_s)), 0.5);
}

TEST(ClockAlignment, DropsStampsThatRunBackwards) {
  ClockAlignment alignment;
  alignment.add({time_from_ns(100), time_from_ns(50), time_from_ns(40), time_from_ns(110)});
  alignment.add({time_from_ns(100), time_from_ns(50), time_from_ns(90), time_from_ns(110)});
  EXPECT_EQ(alignment.dropped(), 2);
  EXPECT_FALSE(alignment.bound().has_value());
}

TEST(ClockAlignment, DropsTimesWhoseDifferencesOverflow) {
  ClockAlignment alignment;
  Clocks clocks{0.2, 0.0};
  for (const std::int64_t far : {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    ClockExchange e = clocks.exchange(1e-4, 0, 1e-4, 0);
    e.arm_receive = e.arm_send = time_from_ns(far);
    alignment.add(e);
    e = clocks.exchange(1e-4, 0, 1e-4, 0);
    e.host_send = time_from_ns(far);
    alignment.add(e);
  }
  EXPECT_EQ(alignment.dropped(), 4);
  EXPECT_FALSE(alignment.bound());
}

}  // namespace
}  // namespace armsight::host
