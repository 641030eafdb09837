#include "host/status.hpp"

#include <cstdio>
#include <ostream>

#include "host/json_out.hpp"
#include "host/motion.hpp"
#include "host/text.hpp"
#include "protocol/atomic_file.hpp"

namespace armsight::host {
namespace {

constexpr Duration kRetryPeriod = std::chrono::seconds(1);
constexpr Duration kStatisticsTimeout = std::chrono::milliseconds(1200);  // the controller tells them every second

std::string joints_text(HostIo& io) {
  if (io.arm().state()->q_reading_rad().empty()) return "not known, they have not reported yet";
  return degrees_text(reading_now(io)) + " deg read, " + degrees_text(real_now(io)) + " deg real";
}

std::string fault_text(const ArmLink& arm) {
  const std::uint32_t code = arm.state()->fault_code();
  if (code == 0) return "none";
  return std::to_string(code) + (arm.fault() ? " (" + arm.fault()->side() + "): " + arm.fault()->text() : "");
}

void print(const wire::ControllerStatistics& s, std::ostream& out) {
  out << "cycles:     " << s.cycles() << ", " << s.missed() << " missed, tick " << fixed(s.tick_us_p50(), 1)
      << " us (p99.9 " << fixed(s.tick_us_p999(), 1) << " us), " << s.protocol_errors() << " protocol errors\n"
      << duration_table(s);
  for (const std::string& line : s.degraded()) out << "degraded:   " << line << "\n";
}

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

std::string duration_name(const wire::DurationHistogram& row) {
  switch (row.what()) {
    case wire::MEASURED_DURATION_WAKE_UP: return "wake-up late";
    case wire::MEASURED_DURATION_TICK: return "tick";
    case wire::MEASURED_DURATION_SYNC_PERIOD: return "SYNC off its period";
    case wire::MEASURED_DURATION_TPDO1: return "TPDO1 of node " + std::to_string(row.node());
    default: return "unknown duration " + std::to_string(static_cast<int>(row.what()));
  }
}

std::string duration_table(const wire::ControllerStatistics& statistics) {
  if (statistics.durations().empty()) return "";
  char line[96];
  std::snprintf(line, sizeof line, "%-12s%-20s %11s %10s %10s %10s\n", "durations:", "", "count", "p50 us", "p99.9 us",
                "max us");
  std::string table = line;
  for (const wire::DurationHistogram& row : statistics.durations()) {
    std::snprintf(line, sizeof line, "%-12s%-20s %11llu %10.1f %10.1f %10.1f\n", "", duration_name(row).c_str(),
                  static_cast<unsigned long long>(row.count()), row.p50_us(), row.p999_us(), row.max_us());
    table += line;
  }
  return table;
}

void run_status(HostIo& io, const std::filesystem::path& json_file, std::ostream& out) {
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
      << degrees_text(model.beta) << " deg\n"
      << "fault:      " << fault_text(arm) << "\n";
  if (arm.statistics()) print(*arm.statistics(), out);
  out << std::flush;
  if (json_file.empty()) return;
  if (!arm.statistics()) throw CommandFailed("status: the controller told no statistics");
  write_file_atomically(json_file, to_json(*arm.statistics()));
}

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

}  // namespace armsight::host
