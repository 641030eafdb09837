// arm_controller: command line, signals, exit codes.
#include <csignal>
#include <cstdio>

#include "arm_controller/program.hpp"
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
    catch_signals();
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
