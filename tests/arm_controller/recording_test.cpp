// What is written, and who learns when it cannot be.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "tests/arm_controller/link_rig.hpp"

namespace armsight::arm::test {
namespace {

/// No file of this process grows beyond so many bytes: what a full disk looks like to it.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

bool is_statistics(const wire::Envelope& e) { return e.has_statistics(); }

TEST(Recording, AFullDiskIsToldInTheStatistics) {
  LinkRig rig;
  auto peer = rig.commander();
  const auto before = rig.wait_for(*peer, is_statistics);
  ASSERT_TRUE(before);
  EXPECT_FALSE(before->statistics().recording_is_broken());
  const SmallDisk full(100);
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.statistics().recording_is_broken(); }));
}

TEST(Recording, EventsThatFoundNoRoomAreCountedInTheStatistics) {
  LinkRig rig;
  auto peer = rig.commander();
  const std::size_t room = decltype(rig.mailboxes.events)::capacity();
  const auto answer = std::make_unique<Event>(AnswerEvent{});
  for (std::size_t i = 0; i < room + 3; ++i) rig.mailboxes.events.push(*answer);
  EXPECT_TRUE(rig.wait_for(*peer, [](const auto& e) { return e.statistics().events_lost() == 3; }));
}

}  // namespace
}  // namespace armsight::arm::test
