// `host stop` reaches a controller that tells next to nothing, from a folder without a robot file.
#include <gtest/gtest.h>

#include "host/command_line.hpp"
#include "tests/host/app_controller_stub.hpp"

namespace armsight::host {
namespace {

using wire::Envelope;

int run_stop_at(const std::string& address) {
  CommandLine line;
  line.verb = Verb::kStop;
  line.arm = address;
  line.robot = "no/such/robot.yaml";
  return run(line);
}

TEST(Stop, NeedsNoRobotFileAndNoModel) {
  test::ServedStub controller([](test::ControllerStub& stub, const Envelope& message) {
    if (message.has_hello()) {
      Envelope reply;
      reply.mutable_hello_reply()->set_session(7);
      stub.tell(std::move(reply));
    }
    if (message.has_stop()) stub.accept(message);
    stub.tell_mode(wire::MODE_HOLD);
  });
  EXPECT_EQ(run_stop_at(controller.address()), 0);
  const auto taken = controller.finish();
  ASSERT_GE(taken.size(), 2U);
  EXPECT_EQ(taken[0], Envelope::kHello);
  EXPECT_EQ(taken[1], Envelope::kStop);
}

TEST(Stop, IsSentBeforeAnythingIsHeard) {
  test::ServedStub mute([](test::ControllerStub&, const Envelope&) {});
  EXPECT_EQ(run_stop_at(mute.address()), 3) << "nobody says that the arm stopped";
  const auto taken = mute.finish();
  ASSERT_GE(taken.size(), 2U);
  EXPECT_EQ(taken[1], Envelope::kStop);
}

TEST(Stop, TellsThatTheControllerSpeaksAnotherProtocol) {
  test::ServedStub other([](test::ControllerStub& stub, const Envelope& message) {
    if (!message.has_hello()) return;
    Envelope refusal;
    refusal.mutable_refusal()->set_refused_sequence(message.sequence());
    refusal.mutable_refusal()->set_reason(wire::REFUSAL_REASON_VERSION);
    refusal.mutable_refusal()->set_text("peer speaks protocol 1.0, the controller 2.0");
    stub.tell(std::move(refusal));
  });
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_stop_at(other.address()), 1);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("the controller 2.0"), std::string::npos) << said;
}

}  // namespace
}  // namespace armsight::host
