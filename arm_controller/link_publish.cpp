// LinkServer, third part: what goes out.
#include <cstdio>
#include <fstream>

#include "arm_controller/link_reports.hpp"
#include "arm_controller/link_server.hpp"
#include "protocol/framing.hpp"

namespace armsight::arm {
namespace {

constexpr Duration kStatePeriod = std::chrono::milliseconds(20);
constexpr Duration kStatisticsPeriod = std::chrono::seconds(1);
constexpr std::uint64_t kBlackBoxPiece = 32 * 1024;
constexpr Duration kSaveAgainAfter = std::chrono::seconds(1);

/// 0: it names none.
std::uint64_t revision_in(const Event& event) {
  if (const auto* goal = std::get_if<GoalEvent>(&event)) return goal->model_revision;
  if (const auto* look = std::get_if<FilterEvent>(&event)) return look->model_revision;
  if (const auto* model = std::get_if<ModelEvent>(&event)) return model->model.revision;
  return 0;
}

}  // namespace

void LinkServer::send(LinkSession& peer, wire::Envelope& envelope, Time now) {
  if (!peer.stream->is_open()) return;
  envelope.set_protocol_version(wire::kProtocolVersion);
  envelope.set_sequence(++peer.last_sent);
  envelope.set_sent_time_ns(to_ns(now));
  envelope.set_session(peer.session);
  peer.stream->send(envelope.SerializeAsString());
  files_.record_link(false, peer.stream->peer_name(), envelope, now);
}

void LinkServer::broadcast(wire::Envelope& envelope, Time now) {
  for (auto& session : sessions_)
    if (session->session != 0) send(*session, envelope, now);
}

void LinkServer::accept(const Message& m) {
  wire::Envelope envelope;
  envelope.mutable_accepted()->set_accepted_sequence(m.envelope.sequence());
  send(m.peer, envelope, m.now);
}

void LinkServer::refuse(const Message& m, const Refused& why) {
  send_refusal(m.peer, m.envelope.sequence(), why, m.now);
}

void LinkServer::send_refusal(LinkSession& peer, std::uint64_t sequence, const Refused& why, Time now) {
  wire::Envelope envelope;
  wire::Refusal& refusal = *envelope.mutable_refusal();
  refusal.set_refused_sequence(sequence);
  refusal.set_reason(why.reason);
  refusal.set_text(why.text);
  send(peer, envelope, now);
}

/// To a session that may be gone by now.
void LinkServer::send_refusal(const Tag& tag, const Refused& why, Time now) {
  for (auto& session : sessions_)
    if (session->session == tag.session) send_refusal(*session, tag.sequence, why, now);
}

void LinkServer::protocol_error(LinkSession& peer, std::uint64_t sequence, const Refused& why, Time now) {
  ++protocol_errors_;
  send_refusal(peer, sequence, why, now);
  if (++peer.protocol_errors >= LinkSession::kMaxProtocolErrors) peer.stream->close("five protocol errors");
}

void LinkServer::publish(Time now) {
  take_events(now);
  if (unsaved_ && clock_.is_lockstep()) files_.wait_idle();
  watch_saving(now);
  tell_saved(now);
  if (now >= next_state_) publish_state(now);
  if (now >= next_statistics_) publish_statistics(now);
}

void LinkServer::take_events(Time now) {
  if (const auto state = mailboxes_.state.take()) state_ = *state;
  if (const auto check = mailboxes_.self_check.take()) tell_self_check(*check);
  Event event;
  while (mailboxes_.events.pop(event)) publish_event(event, now);
}

void LinkServer::publish_event(const Event& event, Time now) {
  if (const auto* answer = std::get_if<AnswerEvent>(&event)) return publish_answer(*answer, now);
  if (const auto* model = std::get_if<ModelEvent>(&event)) {
    const bool is_new = model->source == ModelSource::kCalibration || model->source == ModelSource::kFilter;
    if (!is_new) loaded_revision_ = model->model.revision;
    if (is_new) {
      files_.save_model(*model);
      unsaved_ = *model;
    }
  }
  hold_or_tell(event, now);
}

// Why saved first: a revision that a peer has seen must survive a crash, or numbers would be given twice.
void LinkServer::hold_or_tell(const Event& event, Time now) {
  if (held_.empty() && revision_in(event) <= revision_on_disk()) return tell(event, now);
  const bool is_stop = std::holds_alternative<FaultEvent>(event) || std::holds_alternative<StopEvent>(event);
  if (is_stop) return tell(event, now);  // names none, and cannot wait
  held_.push_back(event);
}

void LinkServer::tell(const Event& event, Time now) {
  wire::Envelope envelope;
  if (const auto* model = std::get_if<ModelEvent>(&event)) {
    model_ = *model;
    to_wire(*model, *envelope.mutable_model_update());
  }
  if (const auto* goal = std::get_if<GoalEvent>(&event)) to_wire(*goal, *envelope.mutable_goal_status());
  if (const auto* look = std::get_if<FilterEvent>(&event)) to_wire(*look, *envelope.mutable_filter_report());
  if (const auto* fault = std::get_if<FaultEvent>(&event)) {
    fault_ = *fault;
    to_wire(*fault, *envelope.mutable_fault_report());
  }
  if (const auto* stop = std::get_if<StopEvent>(&event)) {
    stop_ = *stop;
    to_wire(*stop, robot_.collision, *envelope.mutable_stop_report());
  }
  broadcast(envelope, now);
}

void LinkServer::publish_answer(const AnswerEvent& answer, Time now) {
  for (auto& session : sessions_) {
    if (session->session != answer.tag.session) continue;
    if (answer.answer != Answer::kAccepted)
      return send_refusal(*session, answer.tag.sequence, {to_wire(answer.answer), answer.text}, now);
    wire::Envelope envelope;
    envelope.mutable_accepted()->set_accepted_sequence(answer.tag.sequence);
    return send(*session, envelope, now);
  }
}

void LinkServer::tell_saved(Time now) {
  while (!held_.empty() && revision_in(held_.front()) <= revision_on_disk()) {
    tell(held_.front(), now);
    held_.pop_front();
  }
}

// The newest is tried again until there is room: the file holds one model, and those before it are overtaken.
void LinkServer::watch_saving(Time now) {
  if (unsaved_ && unsaved_->model.revision <= revision_on_disk()) unsaved_.reset();
  if (files_.take_save_failure()) {
    mailboxes_.model_not_saved.set();
    save_again_at_ = now + kSaveAgainAfter;
  }
  if (!save_again_at_ || now < *save_again_at_) return;
  save_again_at_.reset();
  if (unsaved_) files_.save_model(*unsaved_);
}

void LinkServer::publish_state(Time now) {
  next_state_ = now + kStatePeriod - seconds_to_duration(0.5 * robot_.controller.period_s);
  if (sessions_.empty()) return;
  wire::Envelope envelope;
  to_wire(state_, *envelope.mutable_arm_state());
  envelope.mutable_arm_state()->set_model_revision(std::min(state_.model.revision, revision_on_disk()));
  for (auto& session : sessions_) {
    if (session->session == 0) continue;
    envelope.mutable_arm_state()->set_has_lease(session->session == lease_.session);
    send(*session, envelope, now);
  }
}

void LinkServer::publish_statistics(Time now) {
  next_statistics_ = now + kStatisticsPeriod - seconds_to_duration(0.5 * robot_.controller.period_s);
  wire::Envelope envelope;
  wire::ControllerStatistics& s = *envelope.mutable_statistics();
  s.set_rate_hz(1.0 / robot_.controller.period_s);
  s.set_cycles(statistics_.cycles.load(std::memory_order_relaxed));
  s.set_missed(statistics_.missed.load(std::memory_order_relaxed));
  s.set_tick_us_p50(1e-3 * static_cast<double>(statistics_.tick.quantile_ns(0.5)));
  s.set_tick_us_p999(1e-3 * static_cast<double>(statistics_.tick.quantile_ns(0.999)));
  add_durations(statistics_, robot_, s);
  s.set_looks_overflowed(mailboxes_.looks.overflows());
  s.set_protocol_errors(protocol_errors_);
  s.set_events_lost(mailboxes_.events.overflows());
  s.set_ticks_unrecorded(statistics_.tape_overflows.load(std::memory_order_relaxed));
  s.set_link_unrecorded(files_.link_records_lost());
  s.set_recording_is_broken(files_.recording_is_broken());
  for (const CheckLine& line : short_of_) s.add_degraded("node " + std::to_string(line.node) + ": " + line.text);
  broadcast(envelope, now);
}

// The page goes to the terminal before any message of this step can ask for power; what falls short stays in the status.
void LinkServer::tell_self_check(const SelfCheck& check) {
  short_of_ = lines_of(check);
  std::fputs(to_text(short_of_).c_str(), stdout);
  std::erase_if(short_of_, [](const CheckLine& line) { return line.verdict == Verdict::kOk; });
}

void LinkServer::greet(LinkSession& peer, Time now) {
  if (model_) {
    wire::Envelope envelope;
    to_wire(*model_, *envelope.mutable_model_update());
    send(peer, envelope, now);
  }
  if (fault_ && state_.fault.is_set()) {
    wire::Envelope envelope;
    to_wire(*fault_, *envelope.mutable_fault_report());
    send(peer, envelope, now);
  }
  if (stop_) {
    wire::Envelope envelope;
    to_wire(*stop_, robot_.collision, *envelope.mutable_stop_report());
    send(peer, envelope, now);
  }
}

// One piece an asking: a peer that is slow to take them delays nobody.
void LinkServer::on_black_box(const Message& m) {
  const std::filesystem::path file = files_.newest_black_box();
  wire::Envelope envelope;
  wire::BlackBoxChunk& chunk = *envelope.mutable_black_box_chunk();
  chunk.set_name(file.filename().string());
  chunk.set_offset(m.envelope.black_box_request().offset());
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!file.empty() && in) {
    chunk.set_total_bytes(static_cast<std::uint64_t>(in.tellg()));
    const std::uint64_t left = chunk.total_bytes() - std::min(chunk.total_bytes(), chunk.offset());
    std::string& data = *chunk.mutable_data();
    data.resize(std::min<std::uint64_t>(left, kBlackBoxPiece));
    in.seekg(static_cast<std::streamoff>(chunk.offset()));
    if (!data.empty() && !in.read(data.data(), static_cast<std::streamsize>(data.size()))) data.clear();
  }
  send(m.peer, envelope, m.now);
}

void LinkServer::close(Time now) {
  wire::Envelope bye;
  bye.mutable_bye();
  broadcast(bye, now);
  for (auto& session : sessions_) session->stream->close("the controller leaves");
}

}  // namespace armsight::arm
