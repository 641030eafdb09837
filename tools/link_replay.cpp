// link_replay: the hosts of a recording once more, against a fresh simulated arm in lockstep; compares what the
// controller answers. Each recorded connection is a process of its own, as its host was: another participant of the
// clock. A black box is another matter: the executable that wrote it goes through it again (arm_controller --replay),
// alone. Exit codes: 0 same, 1 different, 2 bad flag or file, or a run that cannot be repeated here, 3 peer lost.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tools/command_line.hpp"
#include "tools/replay/link_player.hpp"
#include "tools/report/child_process.hpp"

namespace {

using namespace armsight;
using demo::ChildProcess;

constexpr const char* kName = "link_replay";
constexpr const char* kJoined = "link_replay: joined the simulated clock";
constexpr const char* kDiffers = "differs at ";
constexpr Duration kPeriod = std::chrono::milliseconds(4);
constexpr int kRoleHost = 2;

struct Flags {
  std::string file, arm, clock, controller;
  int connection = 0;                      ///< from 1; 0: all of them
};

int fail(int code, const std::string& what) {
  std::fprintf(stderr, "%s: %s\n", kName, what.c_str());
  return code;
}

std::unique_ptr<net::Clock> join(const Flags& flags) {
  return net::join_sim_clock(flags.clock.substr(std::string("sim:").size()), kName, kRoleHost, kPeriod);
}

std::string result_line(std::size_t number, const replay::PlayResult& result) {
  const std::string connection = "connection " + std::to_string(number) + ": ";
  if (!result.difference)
    return connection + "same: " + std::to_string(result.sent) + " messages sent, " + std::to_string(result.compared) +
           " answers compared";
  char time[40];
  std::snprintf(time, sizeof time, "%.9f", 1e-9 * static_cast<double>(result.difference->arm_time_ns));
  const replay::FieldDifference& what = result.difference->what;
  return connection + kDiffers + time + " s (arm clock), /link, " + what.field + ": recorded " + what.recorded +
         ", replayed " + what.replayed;
}

std::vector<std::size_t> in_order_of_joining(const replay::LinkFile& file) {
  std::vector<std::size_t> order(file.connections.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return file.connections[i].participant; });
  return order;
}

void wait_for_line_or_end(ChildProcess& child, const char* prefix) {
  while (!child.exit_code() && !(prefix != nullptr && child.line_after(prefix))) {
    pollfd readable{child.descriptor(), POLLIN, 0};
    poll(&readable, 1, 50);
    child.drain([](const std::string&) {});
  }
  child.drain([](const std::string&) {});
}

/// The others join one by one while our cycle keeps the time still, each in its recorded place.
std::vector<std::unique_ptr<ChildProcess>> start_others(const Flags& flags, const std::vector<std::size_t>& order) {
  std::vector<std::unique_ptr<ChildProcess>> others;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const std::vector<std::string> command{"/proc/self/exe", flags.file, "--arm", flags.arm, "--clock", flags.clock,
                                           "--connection", std::to_string(order[i] + 1)};
    others.push_back(std::make_unique<ChildProcess>(kName, command));
    wait_for_line_or_end(*others.back(), kJoined);
  }
  return others;
}

int play_one(const replay::LinkFile& file, std::size_t index, const Flags& flags, net::Clock& clock,
             std::string& line) {
  replay::LinkPlayer player(file.connections[index], flags.arm, clock);
  const replay::PlayResult result = player.play();
  line = result_line(index + 1, result);
  return result.difference ? 1 : 0;
}

/// The worst end of all: what kept a connection from being played, else a difference, else 0.
int collect(std::vector<std::unique_ptr<ChildProcess>>& others, int code, std::vector<std::string>& lines) {
  for (auto& child : others) {
    wait_for_line_or_end(*child, nullptr);
    code = std::max(code, *child->exit_code());
    for (const std::string& line : child->lines())
      if (!line.starts_with(kJoined)) lines.push_back(line.starts_with("link_replay: ") ? line.substr(13) : line);
  }
  return code;
}

void print(const std::vector<std::string>& lines, int code) {
  const std::string* first = nullptr;
  double first_s = 0.0;
  for (const std::string& line : lines) {
    std::printf("%s: %s\n", kName, line.c_str());
    const std::size_t at = line.find(kDiffers);
    if (at == std::string::npos) continue;
    const double time_s = std::strtod(line.c_str() + at + std::string(kDiffers).size(), nullptr);
    if (first == nullptr || time_s < first_s) first = &line, first_s = time_s;
  }
  if (code == 0) std::printf("%s: same\n", kName);
  if (code == 1 && first != nullptr) std::printf("%s: different, first: %s\n", kName, first->c_str());
}

bool is_black_box(const std::string& file) try {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw RecordingError(file + ": cannot be read");
  RecordingReader reader(in);
  RecordedMessage message;
  return reader.next(message) && message.topic == "/info" && reader.next(message) && message.topic == "/state";
} catch (const RecordingError& error) {
  const std::string what = error.what();
  throw RecordingError(what.starts_with(file) ? what : file + ": " + what);
}

/// Becomes the controller; comes back only where there is none.
int go_through_black_box(const Flags& flags) {
  std::string program = flags.controller;
  if (program.empty())
    program = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "arm_controller").string();
  std::fflush(nullptr);
  execl(program.c_str(), program.c_str(), "--replay", flags.file.c_str(), static_cast<char*>(nullptr));
  return fail(2, "--controller " + program + ": cannot be started; it must be the executable that wrote the black box");
}

int run(const Flags& flags) {
  const replay::LinkFile file = replay::load_link_file(flags.file);
  const bool is_alone = flags.connection != 0;
  if (is_alone && static_cast<std::size_t>(flags.connection) > file.connections.size())
    return fail(2, "--connection " + std::to_string(flags.connection) + ": the recording holds " +
                       std::to_string(file.connections.size()));
  const std::vector<std::size_t> order = in_order_of_joining(file);
  std::unique_ptr<net::Clock> clock = join(flags);
  std::vector<std::string> lines(1);
  if (is_alone) {
    const int code = play_one(file, static_cast<std::size_t>(flags.connection - 1), flags, *clock, lines[0]);
    std::printf("%s: %s\n", kName, lines[0].c_str());
    return code;
  }
  check_replayable(file.connections[order[0]], *clock);
  auto others = start_others(flags, order);
  int code = play_one(file, order[0], flags, *clock, lines[0]);
  clock.reset();  // the others go on
  code = collect(others, code, lines);
  print(lines, code);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  tools::CommandLine line(
      "Sends a recording's messages to a fresh arm_controller on a simulated arm and compares its answers.", kName);
  Flags flags;
  line.add("FILE", flags.file,
           "recording with /link messages: STATE/ticks.mcap of arm_controller, or link_record's; or a black box")
      .required();
  line.add("--arm", flags.arm, "ADDR:PORT of the fresh arm_controller; a black box needs none");
  line.add("--controller", flags.controller,
           "black box: the arm_controller that wrote it; default: the one beside this program");
  line.add("--clock", flags.clock,
           "sim:PATH of its arm_sim, in lockstep, same seed; recordings never drive a real arm");
  line.add("--connection", flags.connection, "this one of the recorded connections only, from 1").positive();
  if (const auto code = line.parse(argc, argv)) return *code;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    if (is_black_box(flags.file)) return go_through_black_box(flags);
    if (!flags.clock.starts_with("sim:"))
      return fail(2, "--clock sim:PATH is needed: recordings are sent to a simulated arm only, never to a real one");
    if (flags.arm.empty()) return fail(2, "--arm ADDR:PORT is needed: the recording is sent to a fresh arm_controller");
    return run(flags);
  } catch (const RecordingError& error) {
    return fail(2, error.what());
  } catch (const replay::NotReplayable& error) {
    return fail(2, error.what());
  } catch (const std::exception& error) {  // the clock, the controller
    return fail(3, error.what());
  }
}
