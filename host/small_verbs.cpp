#include "host/small_verbs.hpp"

#include <ostream>

#include "host/json_out.hpp"
#include "host/motion.hpp"
#include "host/text.hpp"
#include "protocol/atomic_file.hpp"

namespace armsight::host {
namespace {

constexpr double kPosePosition_m = 0.001;
constexpr Duration kStopTimeout = std::chrono::seconds(5);
constexpr Duration kRetryPeriod = std::chrono::seconds(1);
constexpr Duration kStatisticsTimeout = std::chrono::milliseconds(1200);  // the controller tells them every second

std::string joints_text(HostIo& io) {
  if (io.arm().state()->q_reading_rad().empty()) return "not known, they have not reported yet";
  return degrees_text(reading_now(io)) + " deg read, " + degrees_text(real_now(io)) + " deg real";
}

}  // namespace

void run_move(HostIo& io, SessionFiles& files, const JointVector& q_real, const std::optional<Pose>& T_B_G,
              std::ostream& progress) {
  MoveRecord record;
  MotionResult motion;
  if (T_B_G) {
    record.T_B_G = T_B_G;
    const PoseTarget target{wire::GOAL_FRAME_BASE,    *T_B_G,      model_in_force(io).revision, kPosePosition_m,
                            kMovePoseOrientation_rad, real_now(io)};
    motion = drive_to(io, target);
  } else {
    record.q_goal_real = q_real;
    motion = drive_to(io, q_real);
  }
  record.status = motion.status;
  record.state = motion.has_arrived ? "arrived" : motion.why;
  record.model = model_in_force(io);
  if (motion.has_arrived) {  // as it stands, not as it came to the goal's tolerance
    record.status.set_arm_time_ns(io.arm().state()->arm_time_ns());
    *record.status.mutable_q_reading_rad() = io.arm().state()->q_reading_rad();
  }
  files.save_result(to_json(record));
  if (!motion.has_arrived) throw CommandFailed("move: " + motion.why);
  progress << "arrived: joints " << degrees_text(real_now(io)) << " deg, " << fixed(motion.status.position_error_m() * 1e3, 2)
           << " mm, " << fixed(degrees(motion.status.orientation_error_rad()), 2) << " deg from the goal" << std::endl;
}

void run_hand(HostIo& io, double closure, double force_permille, std::ostream& progress) {
  const HandResult hand = move_hand(io, closure, force_permille);
  progress << "hand: fingers at " << fixed(100 * hand.closure, 0) << " % with " << fixed(hand.effort_permille / 10, 0)
           << " % of their force" << std::endl;
}

void run_status(HostIo& io, std::ostream& out) {
  ArmLink& arm = io.arm();
  io.wait_until([&] { return arm.statistics().has_value(); }, kStatisticsTimeout);
  const wire::HelloReply& hello = *arm.hello();
  const wire::ArmState& state = *arm.state();
  const LearnedModel model = model_in_force(io);
  out << "controller: " << hello.program() << ", robot " << hello.robot() << ", bus " << hello.bus() << ", "
      << fixed(hello.rate_hz(), 0) << " Hz\n"
      << "mode:       " << to_text(state.mode()) << (state.is_still() ? ", still" : ", moving") << "\n"
      << "joints:     " << joints_text(io) << "\n"
      << "hand:       " << fixed(100 * state.hand_closure(), 0) << " % closed\n"
      << "model:      revision " << model.revision << " (" << arm.model()->source() << "), offsets "
      << degrees_text(model.beta) << " deg\n";
  if (state.fault_code() != 0) {
    out << "fault:      " << state.fault_code() << (arm.fault() ? " (" + arm.fault()->side() + "): " + arm.fault()->text() : "") << "\n";
  } else {
    out << "fault:      none\n";
  }
  if (const auto& stop = arm.stop_report()) {
    const double age_s = 1e-9 * static_cast<double>(state.arm_time_ns() - stop->arm_time_ns());
    out << "last stop:  " << to_text(*stop) << "; " << fixed(age_s, 1) << " s ago\n";
  }
  if (const auto& s = arm.statistics()) {
    out << "cycles:     " << s->cycles() << ", " << s->missed() << " missed, tick " << fixed(s->tick_us_p50(), 1) << " us (p99.9 "
        << fixed(s->tick_us_p999(), 1) << " us), " << s->protocol_errors() << " protocol errors\n";
    for (const std::string& line : s->degraded()) out << "degraded:   " << line << "\n";
  }
  out << std::flush;
}

namespace {

std::string watch_line(HostIo& io) {
  const wire::ArmState& state = *io.arm().state();
  std::string line = std::string(to_text(state.mode())) + (state.is_still() ? ", still" : ", moving") + ", model " +
                     std::to_string(state.model_revision());
  if (state.fault_code() != 0) line += ", fault " + std::to_string(state.fault_code());
  return line;
}

void watch_this_link(HostIo& io, Time end, std::string& last, std::ostream& out) {
  open_session(io, false);
  const auto has_news = [&] { return watch_line(io) != last; };
  while (io.wait_until(has_news, end - io.now())) out << "watch: " << (last = watch_line(io)) << std::endl;
}

}  // namespace

void run_watch(HostIo& io, double watch_s, std::ostream& out) {
  const Time end = watch_s > 0.0 ? io.now() + seconds_to_duration(watch_s) : Time::max();
  std::string last;
  bool is_lost = false;
  while (io.now() < end) {
    try {
      if (is_lost) {
        io.reconnect();
        out << "watch: connected again" << std::endl;
        is_lost = false;
      }
      watch_this_link(io, end, last, out);
    } catch (const PeerLost& error) {
      if (!is_lost) out << "watch: " << error.what() << "; trying again every second" << std::endl;
      is_lost = true;
      last.clear();
      io.idle(kRetryPeriod);
    }
  }
}

void run_black_box(HostIo& io, const std::filesystem::path& file, std::ostream& out) {
  std::string bytes, name;
  while (true) {
    wire::Envelope request;
    request.mutable_black_box_request()->set_offset(bytes.size());
    io.arm().send(std::move(request));
    std::optional<wire::BlackBoxChunk> chunk;
    if (!io.wait_until([&] { return (chunk = io.arm().take_black_box_chunk()).has_value(); }, kStatisticsTimeout))
      throw CommandFailed("blackbox: no answer; the controller may be older than this host");
    if (chunk->name().empty()) throw CommandFailed("blackbox: there is none: no fault since the controller started");
    const bool is_next = chunk->offset() == bytes.size() && !chunk->data().empty() && (name.empty() || name == chunk->name());
    if (!is_next) throw CommandFailed("blackbox: another fault came while it was fetched; fetch again");
    name = chunk->name();
    bytes += chunk->data();
    if (bytes.size() >= chunk->total_bytes()) break;
  }
  write_file_atomically(file, bytes);
  out << "black box: " << name << ", " << bytes.size() << " bytes, in " << file.string() << "\n"
      << "           go through it again: link_replay " << file.string() << std::endl;
}

void run_stop(HostIo& io, std::ostream& out) {
  wire::Envelope stop;
  stop.mutable_stop()->set_reason("the operator asked for it");
  io.demand(std::move(stop), "stop");
  const auto rests = [&] {
    const auto& state = io.arm().state();
    return state && state->mode() != wire::MODE_SERVO && state->mode() != wire::MODE_STOPPING;
  };
  if (!io.wait_until(rests, kStopTimeout)) {
    if (!io.arm().state()) throw PeerLost("arm controller: took the stop, but tells no state");
    throw CommandFailed("stop: the arm still moves after 5 s");
  }
  out << "stopped: " << to_text(io.arm().state()->mode()) << std::endl;
}

}  // namespace armsight::host
