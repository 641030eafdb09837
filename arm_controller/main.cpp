// arm_controller: command line, signals, exit codes.
#include <csignal>
#include <cstdio>

#include "arm_controller/black_box_replay.hpp"
#include "arm_controller/program.hpp"
#include "arm_controller/real_time.hpp"
#include "arm_controller/socket_can.hpp"

namespace {

std::atomic<bool> g_leaves{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int) { g_leaves = true; }

void catch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int fail(int code, const char* what) {
  std::fprintf(stderr, "arm_controller: %s\n", what);
  return code;
}

int replay(const std::string& file) {
  const armsight::arm::BlackBoxResult result = armsight::arm::replay_black_box(file);
  if (result.difference) {
    std::printf("arm_controller: different, first: %s\n", result.difference->c_str());
    return 1;
  }
  std::printf("arm_controller: same: %llu cycles gone through again, %llu frames compared\n",
              static_cast<unsigned long long>(result.cycles), static_cast<unsigned long long>(result.frames_compared));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace armsight;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    const arm::Flags flags = arm::parse_flags(argc, argv);
    if (flags.help) {
      std::fputs(arm::kHelp, stdout);
      return 0;
    }
    if (!flags.replay.empty()) return replay(flags.replay);
    catch_signals();
    arm::prepare_memory();
    arm::Program program(flags);
    return program.run(g_leaves);
  } catch (const arm::BusError& e) {
    return fail(3, e.what());
  } catch (const net::ClockLost& e) {
    return fail(3, e.what());
  } catch (const std::exception& e) {  // flags, files, configuration, an address that is taken
    return fail(2, e.what());
  }
}
