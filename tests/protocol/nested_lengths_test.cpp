// What a message announces must lie inside it, before the parser is asked.
#include <gtest/gtest.h>

#include "protocol/arm_link.pb.h"
#include "protocol/nested_lengths.hpp"

namespace armsight::wire {
namespace {

std::string goal() {
  Envelope envelope;
  envelope.set_sequence(300);
  envelope.set_sent_time_ns(-1);
  PoseGoal& goal = *envelope.mutable_pose_goal();
  goal.mutable_hand_goal()->set_x_m(0.3);
  for (const double q : {0.1, 0.2, 0.3}) goal.add_q_seed_rad(q);
  return envelope.SerializeAsString();
}

TEST(NestedLengths, OfAWholeMessageFitAndOfEveryBeginningOfItParseOrDoNot) {
  EXPECT_TRUE(lengths_fit(goal()));
  EXPECT_TRUE(lengths_fit(""));
  for (std::size_t size = 0; size < goal().size(); ++size) {
    const std::string part = goal().substr(0, size);
    EXPECT_EQ(lengths_fit(part), Envelope{}.ParseFromString(part)) << size << " bytes";
  }
}

TEST(NestedLengths, BeyondTheirMessageDoNotFit) {
  EXPECT_FALSE(lengths_fit(std::string("\x52\x05", 2))) << "five bytes of none";
  EXPECT_FALSE(lengths_fit(std::string("\x52\x03\x0A\x02\x00", 5))) << "the inner one: two of one";
  EXPECT_TRUE(lengths_fit(std::string("\x52\x03\x0A\x01\x00", 5)));
  EXPECT_FALSE(lengths_fit(std::string("\x52\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x01", 11))) << "2^64 - 1 bytes";
  EXPECT_FALSE(lengths_fit("\x0B")) << "a group";
  EXPECT_FALSE(lengths_fit(std::string(11, '\xFF'))) << "a tag without end";
}

}  // namespace
}  // namespace armsight::wire
