// Joint history and mailboxes: what the threads and the filter rely on.
#include <gtest/gtest.h>

#include <thread>

#include "arm_controller/joint_history.hpp"
#include "arm_controller/mailbox.hpp"
#include "arm_controller/messages.hpp"

namespace armsight::arm {
namespace {

JointVector one(double value) { return JointVector::Constant(5, value); }
Time ms(std::int64_t t) { return time_from_ns(t * 1'000'000); }

TEST(JointHistory, InterpolatesLinearlyBetweenSamples) {
  auto history = std::make_unique<JointHistory>(std::chrono::milliseconds(4));
  for (int i = 0; i < 10; ++i) history->push({ms(100 + 4 * i), one(0.1 * i), one(0.02 * i)});
  const auto at = history->at(ms(109));
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->q_rad[2], 0.225, 1e-12);
  EXPECT_NEAR(at->speed_rad_s[0], 0.06, 1e-12);  // the larger of the two: caution
  EXPECT_NEAR(history->at(ms(100))->q_rad[0], 0.0, 1e-12);
  EXPECT_NEAR(history->at(ms(136))->q_rad[0], 0.9, 1e-12);
}

TEST(JointHistory, RefusesWhatItDoesNotHold) {
  auto history = std::make_unique<JointHistory>(std::chrono::milliseconds(4));
  EXPECT_FALSE(history->at(ms(0)));
  for (int i = 0; i < 10; ++i) history->push({ms(100 + 4 * i), one(i), one(0)});
  EXPECT_FALSE(history->at(ms(99)));
  EXPECT_FALSE(history->at(ms(137)));
  history->push({ms(300), one(10), one(0)});
  EXPECT_FALSE(history->at(ms(200)));  // a gap is no line
}

TEST(JointHistory, BridgesLostSamplesAtAnyRate) {
  auto slow = std::make_unique<JointHistory>(std::chrono::milliseconds(25));
  slow->push({ms(100), one(0), one(0)});
  slow->push({ms(125), one(1), one(0)});
  slow->push({ms(200), one(4), one(0)});  // two lost
  ASSERT_TRUE(slow->at(ms(110)));
  ASSERT_TRUE(slow->at(ms(150)));
  EXPECT_NEAR(slow->at(ms(150))->q_rad[0], 2.0, 1e-12);
}

TEST(JointHistory, ForgetsTheOldestAndIgnoresTimeThatDoesNotRise) {
  auto history = std::make_unique<JointHistory>(std::chrono::milliseconds(4));
  for (int i = 0; i < 3000; ++i) history->push({ms(4 * i), one(i), one(0)});
  EXPECT_EQ(history->size(), JointHistory::kCapacity);
  EXPECT_FALSE(history->at(ms(4 * 1900)));
  EXPECT_TRUE(history->at(ms(4 * 2000)));
  history->push({ms(4 * 2999), one(-1), one(0)});
  EXPECT_EQ(history->newest(0).q_rad[0], 2999);
}

TEST(Slot, HandsOutTheNewestValueOnceAndReturnsWhatItReplaced) {
  Slot<int> slot;
  EXPECT_FALSE(slot.take());
  EXPECT_FALSE(slot.put(1));
  EXPECT_EQ(slot.put(2), 1);
  EXPECT_EQ(slot.take(), 2);
  EXPECT_FALSE(slot.take());
  EXPECT_FALSE(slot.put(3));
}

TEST(Slot, NeverTearsBetweenTwoThreads) {
  struct Pair { std::uint64_t a = 0, b = 0; };
  Slot<Pair> slot;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= 50000; ++i) slot.put({i, ~i});
  });
  std::uint64_t last = 0;
  while (last < 50000) {
    const auto pair = slot.take();
    if (!pair) continue;
    ASSERT_EQ(pair->a, ~pair->b);
    ASSERT_GT(pair->a, last);
    last = pair->a;
  }
  writer.join();
}

TEST(StickyFlag, StaysUntilItIsTaken) {
  StickyFlag flag;
  flag.set();
  flag.set();
  EXPECT_TRUE(flag.take());
  EXPECT_FALSE(flag.take());
}

TEST(Ring, RefusesAndCountsWhatFindsNoRoom) {
  auto mailboxes = std::make_unique<Mailboxes>();
  for (std::size_t i = 0; i < kMaxLooks; ++i) EXPECT_TRUE(mailboxes->looks.push({}));
  EXPECT_FALSE(mailboxes->looks.push({}));
  EXPECT_EQ(mailboxes->looks.overflows(), 1u);
  Look look;
  EXPECT_TRUE(mailboxes->looks.pop(look));
  EXPECT_TRUE(mailboxes->looks.push({}));
}

}  // namespace
}  // namespace armsight::arm
