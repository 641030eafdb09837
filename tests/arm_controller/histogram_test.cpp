// The histograms of the cycle: exact where they claim it, never more than a bucket off anywhere.
#include "arm_controller/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "tests/arm_controller/link_rig.hpp"

namespace armsight::arm::test {
namespace {

TEST(Histogram, ItsBucketsFollowEachOtherWithoutGap) {
  for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
    EXPECT_EQ(Histogram::bucket_of(Histogram::upper_ns(i)), i);
    EXPECT_EQ(Histogram::bucket_of(Histogram::upper_ns(i) + 1), std::min(i + 1, Histogram::kBuckets - 1));
  }
  EXPECT_EQ(Histogram::bucket_of(-5), 0u);
}

TEST(Histogram, ItsQuantilesAreThoseOfTheSortedDurationsToABucket) {
  constexpr std::size_t kCount = 1 << 13;  // a power of two: shares of it are exact
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> any(9.0, 3.0);  // median 8 µs, from below a nanosecond to seconds
  const auto histogram = std::make_unique<Histogram>();
  std::vector<std::int64_t> sorted;
  for (std::size_t i = 0; i < kCount; ++i) {
    sorted.push_back(std::min<std::int64_t>(30'000'000'000, static_cast<std::int64_t>(any(random))));
    histogram->add(Duration{sorted.back()});
  }
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(histogram->count(), sorted.size());
  EXPECT_EQ(histogram->longest_ns(), sorted.back());
  for (std::size_t k = 1; k <= kCount; ++k) {
    const std::int64_t reference = sorted[k - 1];
    const std::int64_t quantile = histogram->quantile_ns(static_cast<double>(k) / kCount);
    ASSERT_EQ(Histogram::bucket_of(quantile), Histogram::bucket_of(reference)) << k;
    ASSERT_GE(quantile, reference) << k;
    ASSERT_LE(static_cast<double>(quantile), static_cast<double>(reference) * (1.0 + 1.0 / 32.0)) << k;
    if (reference < 64) {
      ASSERT_EQ(quantile, reference) << k;
    }
  }
}

TEST(Histogram, WhatLastsTooLongIsCountedAndItsLengthKept) {
  const auto histogram = std::make_unique<Histogram>();
  histogram->add(std::chrono::hours(1));
  EXPECT_EQ(histogram->count(), 1u);
  EXPECT_EQ(histogram->longest_ns(), 3'600'000'000'000);
}

class Timing : public testing::Test {
 protected:
  void at(std::int64_t us, std::uint32_t id, bool is_own_echo, std::uint8_t bus = 0) {
    timing_.note({CanFrame{id, 0, {}}, time_from_ns(1000 * us), is_own_echo, bus});
  }
  /// The elbow speaks DAMIAO: command 4, sample 0x14.
  static RobotConfig mixed_robot() {
    RobotConfig robot = nominal_robot();
    robot.drives[3].family = DriveFamily::kDamiao;
    robot.drives[3].mit.reply_id = 0x14;
    return robot;
  }
  const RobotConfig robot_ = mixed_robot();
  const std::unique_ptr<LoopStatistics> statistics_ = std::make_unique<LoopStatistics>();
  BusTiming timing_{robot_, *statistics_};
};

TEST_F(Timing, TellsHowFarSyncIsFromItsPeriodEitherWay) {
  for (const std::int64_t us : {0, 4000, 7990, 12020}) at(us, kSyncId, true);
  EXPECT_EQ(statistics_->sync_period.count(), 3u);
  EXPECT_EQ(statistics_->sync_period.longest_ns(), 30'000);
  EXPECT_EQ(statistics_->sync_period.quantile_ns(0.3), 0);
}

TEST_F(Timing, TellsHowLongEachNodeTakesToAnswerSync) {
  at(100, 0x181, false);  // before the first SYNC: an answer to nothing
  at(1000, kSyncId, true);
  at(1300, 0x181, false);
  at(1900, 0x186, false);
  at(1950, 0x1FF, false);  // nobody's
  at(1960, kSyncId, false);
  EXPECT_EQ(statistics_->tpdo1[0].count(), 1u);
  EXPECT_EQ(statistics_->tpdo1[0].longest_ns(), 300'000);
  EXPECT_EQ(statistics_->tpdo1[5].longest_ns(), 900'000);  // the hand
  EXPECT_EQ(statistics_->tpdo1[1].count(), 0u);
  EXPECT_EQ(statistics_->sync_period.count(), 0u);
}

TEST_F(Timing, TellsTheSyncsOfTwoBusesApart) {
  for (const std::int64_t us : {0, 4000, 8000}) {
    at(us, kSyncId, true, 0);
    at(us + 65, kSyncId, true, 1);
  }
  at(8300, 0x182, false, 1);
  EXPECT_EQ(statistics_->sync_period.count(), 4u);
  EXPECT_EQ(statistics_->sync_period.longest_ns(), 0);
  EXPECT_EQ(statistics_->tpdo1[1].longest_ns(), 235'000) << "counted from the SYNC of its own bus";
}

TEST_F(Timing, TellsHowLongAMotorTakesToAnswerItsCommand) {
  at(1000, kSyncId, true);
  at(1100, 4, true);
  at(1250, 0x14, false);
  at(1300, 0x184, false);  // no node of that number
  EXPECT_EQ(statistics_->tpdo1[3].count(), 1u);
  EXPECT_EQ(statistics_->tpdo1[3].longest_ns(), 150'000);
}

TEST(Statistics, CarryTheHistogramsOfTheCyclesThatRan) {
  LinkRig rig;
  auto peer = rig.commander();
  rig.statistics.wake_up.add(std::chrono::microseconds(17));
  const auto told = rig.wait_for(*peer, [](const auto& e) { return e.statistics().durations_size() > 3; });
  ASSERT_TRUE(told);
  const wire::ControllerStatistics& s = told->statistics();
  EXPECT_EQ(s.durations(0).what(), wire::MEASURED_DURATION_WAKE_UP);
  EXPECT_EQ(s.durations(0).max_us(), 17.0);
  EXPECT_EQ(s.durations(1).what(), wire::MEASURED_DURATION_TICK);
  EXPECT_EQ(s.durations(1).count(), s.cycles());
  EXPECT_EQ(s.durations(2).what(), wire::MEASURED_DURATION_SYNC_PERIOD);
  EXPECT_EQ(s.durations(3).what(), wire::MEASURED_DURATION_TPDO1);
  EXPECT_EQ(s.durations(3).node(), rig.robot.drives[0].node);
  for (const wire::DurationHistogram& row : s.durations()) {
    std::uint64_t total = 0;
    for (const std::uint64_t count : row.counts()) total += count;
    EXPECT_EQ(total, row.count());
    EXPECT_EQ(row.upper_ns_size(), row.counts_size());
  }
}

}  // namespace
}  // namespace armsight::arm::test
