// What is written, and who learns when it cannot be.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "protocol/recording.hpp"
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

std::size_t times_in(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST(Recording, APositionThatCannotBeWrittenIsSaidOnce) {
  LinkRig rig;
  std::filesystem::create_directories(rig.folder / "position.txt" / "in the way");
  testing::internal::CaptureStderr();
  rig.cycles(1000);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(rig.files->recording_is_broken());
  EXPECT_EQ(times_in(said, "position.txt"), 1u) << said;
}

TEST(Recording, ABlackBoxOfAnEarlierRunIsNotOverwritten) {
  const auto end = [](LinkRig& rig) {
    rig.cycles(300);
    rig.bus.drive(2).is_silent = true;
    for (int i = 0; i < 100 && rig.files->newest_black_box().empty(); ++i) rig.cycle();
    return rig.files->newest_black_box();
  };
  LinkRig earlier, later;
  const std::filesystem::path there = later.folder / end(earlier).filename();
  std::ofstream(there) << "earlier";
  const std::filesystem::path written = end(later);
  EXPECT_TRUE(std::filesystem::exists(written));
  EXPECT_NE(written, there);
  EXPECT_EQ(written.extension(), ".mcap");
  EXPECT_EQ(std::filesystem::file_size(there), 7u);
}

TEST(Recording, OfTheLinkIsBoundedAndTellsWhatFoundNoRoom) {
  LinkRig rig;
  Tape tape;
  const std::filesystem::path folder = rig.folder / "second";
  std::filesystem::create_directories(folder);
  std::uint64_t lost = 0;
  constexpr std::uint64_t kSent = 5000;
  {
    FileWriter writer(folder, rig.robot, "emulated", "", tape);  // has not begun: what is posted waits
    wire::Envelope envelope;
    envelope.mutable_stop()->set_reason(std::string(4000, 'x'));
    testing::internal::CaptureStderr();
    for (std::uint64_t i = 0; i < kSent; ++i) writer.record_link(true, "peer", envelope, rig.clock.now());
    EXPECT_EQ(times_in(testing::internal::GetCapturedStderr(), "go unrecorded"), 1u);
    lost = writer.link_records_lost();
    EXPECT_GT(lost, kSent * 3 / 4);
    writer.begin(rig.clock.now());
  }
  std::ifstream in(folder / "ticks.mcap", std::ios::binary);
  RecordingReader reader(in);
  std::uint64_t recorded = 0;
  for (RecordedMessage message; reader.next(message);) recorded += message.topic == "/link" ? 1u : 0u;
  EXPECT_EQ(recorded + lost, kSent);
}

}  // namespace
}  // namespace armsight::arm::test
