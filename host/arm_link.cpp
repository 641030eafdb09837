#include "host/arm_link.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace armsight::host {
namespace {

constexpr Duration kHeartbeatPeriod = std::chrono::milliseconds(50);
constexpr std::size_t kRecentStates = 200;    // 4 s of states
constexpr std::size_t kKeptOutcomes = 256;
constexpr std::size_t kKeptReports = 64;

/// The first field that holds a number that is none; nullptr: all are finite.
const char* broken_field(const wire::ArmState& state) {
  const auto are_finite = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  };
  if (!are_finite(state.q_reading_rad())) return "q_reading_rad";
  if (!are_finite(state.speed_rad_s())) return "speed_rad_s";
  if (!are_finite(state.q_command_rad())) return "q_command_rad";
  if (!are_finite(state.torque_nm())) return "torque_Nm";
  if (!std::isfinite(state.hand_closure())) return "hand_closure";
  if (!std::isfinite(state.hand_effort_permille())) return "hand_effort_permille";
  return nullptr;
}

}  // namespace

ArmLink::ArmLink(std::unique_ptr<net::FramedStream> stream, net::Clock& clock, const ArmLinkOptions& options)
    : stream_(std::move(stream)), clock_(clock) {
  wire::Envelope envelope;
  wire::Hello& hello = *envelope.mutable_hello();
  hello.set_protocol_version(wire::kProtocolVersion);
  hello.set_program(options.program);
  hello.set_model_hash(options.model_hash);
  hello.set_role(options.role);
  hello.set_sim_participant(clock_.participant());
  hello_sequence_ = send(std::move(envelope));
}

std::uint64_t ArmLink::send(wire::Envelope message) {
  message.set_protocol_version(wire::kProtocolVersion);
  message.set_sequence(++last_sequence_);
  message.set_sent_time_ns(to_ns(clock_.now()));
  message.set_session(session_);
  if (!stream_->send(message.SerializeAsString())) {
    throw PeerLost("arm controller " + stream_->peer_name() + ": " + stream_->close_reason());
  }
  return last_sequence_;
}

void ArmLink::receive() {
  for (const net::Received& received : stream_->receive()) {
    wire::Envelope message;
    if (!message.ParseFromString(received.payload)) end_link("undecodable message");
    take(message, received.arrival);
  }
  if (!stream_->is_open() && !hello_refusal_) {
    throw PeerLost("arm controller " + stream_->peer_name() + ": connection lost: " + stream_->close_reason());
  }
}

void ArmLink::end_link(const std::string& why) {
  stream_->close(why);
  throw PeerLost("arm controller " + stream_->peer_name() + ": " + why);
}

void ArmLink::take(const wire::Envelope& message, Time arrival) {
  if (message.sequence() <= last_received_) return;  // old or repeated: says nothing new
  last_received_ = message.sequence();
  switch (message.body_case()) {
    case wire::Envelope::kHelloReply:
      hello_ = message.hello_reply();
      session_ = hello_->session();
      break;
    case wire::Envelope::kHeartbeatReply: {
      const wire::HeartbeatReply& r = message.heartbeat_reply();
      alignment_.add({time_from_ns(r.host_send_time_ns()), time_from_ns(r.arm_receive_time_ns()),
                      time_from_ns(r.arm_send_time_ns()), arrival});
      break;
    }
    case wire::Envelope::kRefusal: {
      const CommandOutcome outcome{false, message.refusal().reason(), message.refusal().text()};
      if (message.refusal().refused_sequence() == hello_sequence_) hello_refusal_ = outcome;
      outcomes_[message.refusal().refused_sequence()] = outcome;
      break;
    }
    case wire::Envelope::kAccepted: outcomes_[message.accepted().accepted_sequence()] = {true, {}, {}}; break;
    case wire::Envelope::kArmState: take_state(message.arm_state()); break;
    case wire::Envelope::kGoalStatus: goal_status_ = message.goal_status(); break;
    case wire::Envelope::kModelUpdate: model_ = message.model_update(); break;
    case wire::Envelope::kFilterReport: filter_reports_.push_back(message.filter_report()); break;
    case wire::Envelope::kFaultReport: fault_ = message.fault_report(); break;
    case wire::Envelope::kStopReport: stop_report_ = message.stop_report(); break;
    case wire::Envelope::kStatistics: statistics_ = message.statistics(); break;
    case wire::Envelope::kBlackBoxChunk: chunk_ = message.black_box_chunk(); break;
    default: break;  // a newer controller may tell more than we know
  }
  while (outcomes_.size() > kKeptOutcomes) outcomes_.erase(outcomes_.begin());
  while (filter_reports_.size() > kKeptReports) filter_reports_.pop_front();
}

void ArmLink::take_state(const wire::ArmState& state) {
  if (const char* field = broken_field(state)) end_link(std::string("ArmState.") + field + " is not finite");
  state_ = state;
  if (state.q_reading_rad().empty()) return;  // the joints have not reported yet
  recent_.push_back(state);
  if (recent_.size() > kRecentStates) recent_.pop_front();
}

void ArmLink::heartbeat() {
  if (!hello_) return;
  const Time now = clock_.now();
  if (last_heartbeat_ && now - *last_heartbeat_ < kHeartbeatPeriod) return;
  last_heartbeat_ = now;
  wire::Envelope envelope;
  envelope.mutable_heartbeat()->set_host_send_time_ns(to_ns(now));
  send(std::move(envelope));
}

void ArmLink::say_bye() {
  if (!stream_->is_open()) return;
  wire::Envelope envelope;
  envelope.mutable_bye();
  send(std::move(envelope));
}

std::optional<CommandOutcome> ArmLink::outcome(std::uint64_t sequence) const {
  const auto found = outcomes_.find(sequence);
  if (found == outcomes_.end()) return std::nullopt;
  return found->second;
}

std::optional<wire::FilterReport> ArmLink::take_filter_report() {
  if (filter_reports_.empty()) return std::nullopt;
  wire::FilterReport report = std::move(filter_reports_.front());
  filter_reports_.pop_front();
  return report;
}

std::optional<std::vector<double>> ArmLink::mean_reading(Time arm_from, Time arm_to) const {
  std::vector<double> sum;
  int count = 0;
  for (const wire::ArmState& state : recent_) {
    const Time t = time_from_ns(state.arm_time_ns());
    if (t < arm_from || t > arm_to) continue;
    sum.resize(static_cast<std::size_t>(state.q_reading_rad_size()), 0.0);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += state.q_reading_rad(static_cast<int>(i));
    ++count;
  }
  if (count == 0) return std::nullopt;
  for (double& value : sum) value /= count;
  return sum;
}

}  // namespace armsight::host
