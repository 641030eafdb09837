// What the host makes of the controller's words: numbers that are none end the link, a stop keeps its cause.
#include "host/arm_link.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "host/text.hpp"
#include "tests/host/app_controller_stub.hpp"

namespace armsight::host {
namespace {

using namespace std::chrono_literals;

class Link : public testing::Test {
 protected:
  /// Until the claim holds; a second is long on loopback.
  bool receive_until(const std::function<bool()>& claim) {
    for (int i = 0; i < 100 && !claim(); ++i) {
      const int descriptors[] = {link_.descriptor()};
      net::wait_readable(descriptors, 10ms);
      link_.receive();
    }
    return claim();
  }
  void SetUp() override { controller_.serve(1s, [](const wire::Envelope&) {}); }

  std::unique_ptr<net::Clock> clock_ = net::make_monotonic_clock(4ms);
  test::ControllerStub controller_;
  ArmLink link_{net::connect_tcp(controller_.address(), {}, *clock_, 5s), *clock_, {"test", 0, wire::ROLE_OBSERVE}};
};

TEST_F(Link, EndsAtANumberThatIsNoneAndNamesTheField) {
  wire::Envelope state;
  for (int i = 0; i < 5; ++i) state.mutable_arm_state()->add_q_reading_rad(0.1);
  state.mutable_arm_state()->set_q_reading_rad(2, std::numeric_limits<double>::quiet_NaN());
  controller_.tell(state);
  try {
    receive_until([&] { return link_.state().has_value(); });
    FAIL() << "the state was dropped or taken";
  } catch (const PeerLost& error) {
    EXPECT_NE(std::string(error.what()).find("q_reading_rad"), std::string::npos) << error.what();
  }
  EXPECT_THROW(link_.send({}), PeerLost) << "the link is closed";
}

TEST_F(Link, NamesTheScalarThatIsNone) {
  wire::Envelope state;
  state.mutable_arm_state()->set_hand_effort_permille(std::numeric_limits<double>::infinity());
  controller_.tell(state);
  try {
    receive_until([&] { return link_.state().has_value(); });
    FAIL() << "the state was dropped or taken";
  } catch (const PeerLost& error) {
    EXPECT_NE(std::string(error.what()).find("hand_effort_permille"), std::string::npos) << error.what();
  }
}

TEST_F(Link, KeepsTheNewestStopReport) {
  for (const char* text : {"stop was asked for", "the commander was silent, last heard 204.1 ms ago"}) {
    wire::Envelope stop;
    stop.mutable_stop_report()->set_code(401);
    stop.mutable_stop_report()->set_side("link");
    stop.mutable_stop_report()->set_text(text);
    controller_.tell(stop);
  }
  const auto is_second = [&] { return link_.stop_report() && link_.stop_report()->text().ends_with("ago"); };
  ASSERT_TRUE(receive_until(is_second));
  EXPECT_EQ(to_text(*link_.stop_report()), "401 (link): the commander was silent, last heard 204.1 ms ago");
}

}  // namespace
}  // namespace armsight::host
