#include "arm_controller/link_server.hpp"

#include "protocol/convert.hpp"
#include "protocol/framing.hpp"
#include "protocol/nested_lengths.hpp"

namespace armsight::arm {
namespace {

constexpr const char* kProgram = "arm_controller " ARMSIGHT_VERSION;
// What one peer may keep us busy with: a host says some messages a cycle, none longer than 4 KiB.
constexpr std::size_t kMaxQueued_bytes = 256 * 1024;
constexpr std::size_t kMaxMessagesPerStep = 32;

/// False: it holds no Envelope. Lengths first: the parser would reserve what they announce.
bool parse(std::string_view payload, wire::Envelope& envelope) {
  return wire::lengths_fit(payload) && envelope.ParseFromArray(payload.data(), static_cast<int>(payload.size()));
}

std::uint32_t sim_participant(std::string_view payload) {
  wire::Envelope envelope;
  if (!parse(payload, envelope)) return 0;
  return envelope.has_hello() ? envelope.hello().sim_participant() : 0;
}

/// Sessions of different runs must differ, or a recording could command (splitmix64 of the start).
std::uint64_t scramble(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return (x ^ (x >> 31)) | 1u;
}

net::StreamOptions controllers_end() {
  net::StreamOptions options;
  options.max_incoming = wire::kMaxToController;
  options.max_outgoing = wire::kMaxFromController;
  options.max_queued_bytes = kMaxQueued_bytes;
  options.max_messages_at_once = kMaxMessagesPerStep;
  return options;
}

const Refused kStoppedBefore{wire::REFUSAL_REASON_WRONG_STATE, "stopped before it began"};

/// What a Stop of the same step undoes: it is taken before them, and they must not act after it.
bool moves(const wire::Envelope& e) {
  const bool powers = e.has_mode_request() && e.mode_request().mode() == wire::MODE_HOLD;
  return powers || e.has_joint_goal() || e.has_pose_goal() || e.has_hand_command();
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version / 100) + "." + std::to_string(version % 100);
}

}  // namespace

LinkServer::LinkServer(const std::string& address, const RobotConfig& robot, const std::string& bus,
                       Mailboxes& mailboxes, const LoopStatistics& statistics, FileWriter& files, net::Clock& clock)
    : robot_(robot), model_hash_(model_hash(robot)), bus_(bus), mailboxes_(mailboxes), statistics_(statistics),
      files_(files), clock_(clock),
      server_(address, net::ChannelKind::kLink, controllers_end(), clock, sim_participant),
      next_session_(static_cast<std::uint64_t>(to_ns(clock.now()))),
      lease_length_(seconds_to_duration(robot.controller.lease_s)) {
  state_.q_reading_rad = JointVector::Zero(robot.arm.joint_count());
  state_.model.beta = state_.q_reading_rad;
}

void LinkServer::step(Time now) {
  take_events(now);
  const std::vector<net::StreamServer::Event> events = server_.receive();
  std::vector<std::optional<wire::Envelope>> envelopes(events.size());
  std::size_t first_after_stop = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].is_closed) continue;
    wire::Envelope& envelope = envelopes[i].emplace();
    if (!parse(events[i].message.payload, envelope)) envelopes[i].reset();
    else if (envelope.has_stop()) on_stop({session_of(events[i].stream), envelope, events[i].message.arrival, now});
    if (envelopes[i] && envelope.has_stop()) first_after_stop = i + 1;
  }
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].is_closed) forget(events[i].stream);
    else handle(session_of(events[i].stream), envelopes[i], events[i].message.arrival, now, i < first_after_stop);
  }
  judge_pose_goal(now);
  if (lease_.session != 0 && now > lease_.until) end_lease(FaultCode::kLeaseSilent, now);
}

LinkSession& LinkServer::session_of(net::FramedStream* stream) {
  for (auto& session : sessions_)
    if (session->stream == stream) return *session;
  sessions_.push_back(std::make_unique<LinkSession>());
  sessions_.back()->stream = stream;
  return *sessions_.back();
}

void LinkServer::forget(net::FramedStream* stream) {
  for (auto& session : sessions_)
    if (session->stream == stream && session->session != 0 && session->session == lease_.session)
      end_lease(FaultCode::kConnectionClosed, clock_.now());
  std::erase_if(sessions_, [stream](const auto& session) { return session->stream == stream; });
}

void LinkServer::handle(LinkSession& peer, const std::optional<wire::Envelope>& envelope, Time arrival, Time now,
                        bool is_before_stop) {
  if (envelope && envelope->has_stop())  // taken already; recorded in the order in which it came
    return files_.record_link(true, peer.stream->peer_name(), *envelope, now);
  if (!peer.stream->is_open()) return;
  if (!envelope) return protocol_error(peer, 0, {wire::REFUSAL_REASON_MALFORMED, "the frame holds no Envelope"}, now);
  files_.record_link(true, peer.stream->peer_name(), *envelope, now);
  const Message m{peer, *envelope, arrival, now, is_before_stop};
  if (check_order_of_messages(m)) dispatch(m);
}

// From everybody, with or without session, sequence, lease; also from a peer that has hung up by now.
void LinkServer::on_stop(const Message& m) {
  mailboxes_.stop.set();
  drop_pose_goal(kStoppedBefore, m.now);
  accept(m);
}

bool LinkServer::check_order_of_messages(const Message& m) {
  const wire::Envelope& e = m.envelope;
  const auto no = [&](wire::RefusalReason reason, const std::string& text) {
    protocol_error(m.peer, e.sequence(), {reason, text}, m.now);
    return false;
  };
  if (e.protocol_version() / 100 != wire::kProtocolVersion / 100) {
    no(wire::REFUSAL_REASON_VERSION, "peer speaks protocol " + version_text(e.protocol_version()) +
                                         ", the controller " + version_text(wire::kProtocolVersion));
    m.peer.stream->close("protocol version");
    return false;
  }
  if (const auto refused = check_time(e.sent_time_ns(), "sent_time_ns")) return no(refused->reason, refused->text);
  if (m.peer.session == 0 && !e.has_hello())
    return no(wire::REFUSAL_REASON_NO_HELLO, "the first message must be Hello");
  if (e.session() != m.peer.session)
    return no(wire::REFUSAL_REASON_SESSION, "session = " + std::to_string(e.session()) + ": not this connection's");
  if (e.sequence() <= m.peer.last_received)
    return no(wire::REFUSAL_REASON_SEQUENCE, "sequence = " + std::to_string(e.sequence()) + ": must be above " +
                                                 std::to_string(m.peer.last_received));
  m.peer.last_received = e.sequence();
  return true;
}

void LinkServer::dispatch(const Message& m) {
  renew_lease(m);
  switch (m.envelope.body_case()) {
    case wire::Envelope::kHello: return on_hello(m);
    case wire::Envelope::kHeartbeat: return on_heartbeat(m);
    case wire::Envelope::kBye:
      if (m.peer.session == lease_.session) end_lease(FaultCode::kHostLeft, m.now);
      return m.peer.stream->close("bye");
    case wire::Envelope::kLeaseRequest: return on_lease(m);
    case wire::Envelope::kBlackBoxRequest: return on_black_box(m);
    case wire::Envelope::kModeRequest:
    case wire::Envelope::kJointGoal:
    case wire::Envelope::kPoseGoal:
    case wire::Envelope::kHandCommand:
    case wire::Envelope::kHandPose:
    case wire::Envelope::kRecalibrationStart:
    case wire::Envelope::kModelProposal:
      if (m.peer.session != lease_.session)
        return refuse(m, {wire::REFUSAL_REASON_NO_LEASE, "commands need the lease: send LeaseRequest first"});
      return m.is_before_stop && moves(m.envelope) ? refuse(m, kStoppedBefore) : on_command(m);
    default: break;
  }
  protocol_error(m.peer, m.envelope.sequence(),
                 {wire::REFUSAL_REASON_MALFORMED, "no body, or one that a controller does not take"}, m.now);
}

void LinkServer::on_hello(const Message& m) {
  const wire::Hello& hello = m.envelope.hello();
  if (m.peer.session != 0) return refuse(m, {wire::REFUSAL_REASON_SESSION, "Hello was said already"});
  m.peer.may_command = hello.role() == wire::ROLE_COMMAND;
  if (m.peer.may_command && hello.model_hash() != model_hash_) {
    refuse(m, {wire::REFUSAL_REASON_MODEL_HASH, "model_hash = " + std::to_string(hello.model_hash()) + ", here " +
                                                    std::to_string(model_hash_) +
                                                    ": the two robot files describe different arms"});
    return m.peer.stream->close("model hash");
  }
  m.peer.session = scramble(next_session_++);
  wire::Envelope envelope;
  wire::HelloReply& reply = *envelope.mutable_hello_reply();
  reply.set_protocol_version(wire::kProtocolVersion);
  reply.set_program(kProgram);
  reply.set_model_hash(model_hash_);
  reply.set_session(m.peer.session);
  reply.set_lease_ns(lease_length_.count());
  reply.set_robot(robot_.robot);
  reply.set_joint_count(static_cast<std::uint32_t>(robot_.arm.joint_count()));
  reply.set_rate_hz(1.0 / robot_.controller.period_s);
  reply.set_bus(bus_);
  send(m.peer, envelope, m.now);
  greet(m.peer, m.now);
}

void LinkServer::on_heartbeat(const Message& m) {
  m.peer.age(m.arrival, m.envelope.sent_time_ns());
  wire::Envelope envelope;
  wire::HeartbeatReply& reply = *envelope.mutable_heartbeat_reply();
  reply.set_host_send_time_ns(m.envelope.heartbeat().host_send_time_ns());
  reply.set_arm_receive_time_ns(to_ns(m.arrival));
  reply.set_arm_send_time_ns(to_ns(clock_.now()));
  send(m.peer, envelope, m.now);
}

void LinkServer::on_lease(const Message& m) {
  const bool is_holder = lease_.session == m.peer.session;
  if (!m.peer.may_command)
    return refuse(m, {wire::REFUSAL_REASON_NO_LEASE, "this session observes: say Hello with ROLE_COMMAND"});
  if (m.envelope.lease_request().release()) {
    if (is_holder) end_lease(FaultCode::kLeaseReleased, m.now);
    return accept(m);
  }
  if (lease_.session != 0 && !is_holder)
    return refuse(m, {wire::REFUSAL_REASON_LEASE_TAKEN, "another session commands"});
  lease_ = {m.peer.session, m.arrival + lease_length_, m.arrival};
  post_lease();
  accept(m);
}

void LinkServer::renew_lease(const Message& m) {
  if (m.peer.session == 0 || m.peer.session != lease_.session) return;
  lease_.until = m.arrival + lease_length_;
  lease_.heard = m.arrival;
  post_lease();
}

void LinkServer::end_lease(FaultCode why, Time now) {
  const Lease ended = lease_;
  lease_ = {0, {}, ended.heard, why};
  post_lease();
  const Refused refused{wire::REFUSAL_REASON_NO_LEASE, std::string("lease ended: ") + stop_text(why)};
  drop_pose_goal(refused, now);
  send_refusal({ended.session, 0}, refused, now);
}

void LinkServer::post_lease() { mailboxes_.lease.put(lease_); }

}  // namespace armsight::arm
