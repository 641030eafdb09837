#include "tools/replay/link_player.hpp"

#include <cstdio>

namespace armsight::replay {
namespace {

constexpr Duration kConnectTimeout = std::chrono::seconds(5);
constexpr int kLongestSilence = 500;  // cycles, 2 s: a controller tells its state every 20 ms

std::string seconds_text(std::int64_t ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", 1e-9 * static_cast<double>(ns));
  return text;
}

/// A controller that ended while it was connected said Bye last; in a replay it lives on.
std::size_t count_expected(const Connection& recorded) {
  const std::size_t count = recorded.from_controller.size();
  return count > 0 && recorded.from_controller.back().has_bye() ? count - 1 : count;
}

}  // namespace

void check_replayable(const Connection& recorded, const net::Clock& clock) {
  if (!clock.is_lockstep())
    throw NotReplayable("arm_sim runs at real pace: only lockstep repeats a run (arm_sim --pace lockstep)");
  if (clock.arm_controller() == 0) throw NotReplayable("no arm_controller takes part in this simulated clock");
  if (recorded.to_controller.empty() || !recorded.to_controller.front().has_hello())
    throw NotReplayable("connection of " + recorded.peer + ": does not begin with Hello");
  if (recorded.participant == 0)
    throw NotReplayable("connection of " + recorded.peer +
                        ": its host had no simulated clock, so its times cannot come again");
  if (recorded.participant != clock.participant())
    throw NotReplayable("the recorded host joined the simulated clock as participant " +
                        std::to_string(recorded.participant) + ", this is participant " +
                        std::to_string(clock.participant()) + ": start fresh programs in the order of the recording");
}

LinkPlayer::LinkPlayer(const Connection& recorded, std::string arm_address, net::Clock& clock)
    : recorded_(recorded), expected_(count_expected(recorded)), arm_address_(std::move(arm_address)), clock_(clock) {}

PlayResult LinkPlayer::play() {
  check_replayable(recorded_, clock_);
  wait_for_hello();
  stream_ = net::connect_tcp(arm_address_, net::StreamOptions{}, clock_, kConnectTimeout);
  stream_->set_channel({net::ChannelKind::kLink, clock_.arm_controller()});
  send_due();
  while (!is_over()) {
    clock_.wait_next_cycle();
    receive();
    if (!result_.difference) send_due();
  }
  return result_;
}

void LinkPlayer::wait_for_hello() {
  const std::int64_t hello_ns = recorded_.to_controller.front().sent_time_ns();
  if (to_ns(clock_.now()) > hello_ns)
    throw NotReplayable("the recorded host came at " + seconds_text(hello_ns) + " of its clock, here it is " +
                        seconds_text(to_ns(clock_.now())) +
                        " already: join earlier; and arm_sim needs the seed of the recording");
  while (to_ns(clock_.now()) < hello_ns) clock_.wait_next_cycle();
  if (to_ns(clock_.now()) != hello_ns)
    throw NotReplayable("the recorded host's clock showed " + std::to_string(hello_ns) + " ns, this one never does: " +
                        "arm_sim needs the seed and the rate of the recording");
}

void LinkPlayer::send_due() {
  while (result_.sent < recorded_.to_controller.size() && stream_->is_open()) {
    wire::Envelope envelope = recorded_.to_controller[result_.sent];
    if (envelope.sent_time_ns() > to_ns(clock_.now())) return;
    if (envelope.session() != 0 && envelope.session() == recorded_.session) envelope.set_session(session_);
    stream_->send(envelope.SerializeAsString());
    ++result_.sent;
  }
}

void LinkPlayer::receive() {
  ++silent_cycles_;
  for (const net::Received& received : stream_->receive()) {
    silent_cycles_ = 0;
    wire::Envelope envelope;
    if (!envelope.ParseFromString(received.payload)) return report_missing("an undecodable message");
    take_session(envelope);
    if (!result_.difference) compare(envelope);
  }
  if (!stream_->is_open()) report_missing("the connection closed: " + stream_->close_reason());
  else if (silent_cycles_ > kLongestSilence) report_missing("silence");
}

void LinkPlayer::take_session(const wire::Envelope& replayed) {
  if (!replayed.has_hello_reply()) return;
  if (replayed.hello_reply().bus() != "emulated")
    throw NotReplayable("the controller drives bus \"" + replayed.hello_reply().bus() +
                        "\": recordings never drive a real arm");
  session_ = replayed.hello_reply().session();
}

void LinkPlayer::compare(const wire::Envelope& replayed) {
  if (result_.compared == expected_) {
    const bool has_left =
        result_.sent == recorded_.to_controller.size();  // what comes after the recorded end says nothing
    if (!has_left) result_.difference = {replayed.sent_time_ns(), {"message", "nothing", body_name(replayed)}};
    return;
  }
  const wire::Envelope& recorded = recorded_.from_controller[result_.compared];
  if (auto what = first_difference(recorded, replayed)) result_.difference = {recorded.sent_time_ns(), *what};
  else ++result_.compared;
}

void LinkPlayer::report_missing(const std::string& instead) {
  if (result_.difference) return;
  if (result_.compared < expected_) {
    const wire::Envelope& recorded = recorded_.from_controller[result_.compared];
    result_.difference = {recorded.sent_time_ns(), {"message", body_name(recorded), instead}};
  } else if (result_.sent < recorded_.to_controller.size()) {
    result_.difference = {expected_ == 0 ? 0 : recorded_.from_controller[expected_ - 1].sent_time_ns(),
                          {"message", "nothing", instead}};
  }
}

bool LinkPlayer::is_over() const {
  if (result_.difference || !stream_->is_open()) return true;
  return result_.sent == recorded_.to_controller.size() && result_.compared == expected_;
}

}  // namespace armsight::replay
