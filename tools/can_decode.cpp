// Prints the traffic of a CAN bus live as `candump -L` text: of the emulated bus or of a CAN interface.
#include <csignal>
#include <chrono>
#include <cstdio>
#include <vector>

#include "arm_controller/emulated_bus.hpp"
#include "arm_controller/socket_can.hpp"
#include "protocol/candump.hpp"
#include "protocol/transport/wait.hpp"
#include "tools/command_line.hpp"

namespace {

volatile std::sig_atomic_t is_stopping = 0;
void stop(int) { is_stopping = 1; }

void print(const std::string& interface, const armsight::arm::BusFrame& frame) {
  std::printf("%s\n", armsight::to_candump({frame.time, interface, frame.frame, false}).c_str());
  std::fflush(stdout);
}

int listen_to_emulated(const std::string& path) {
  armsight::arm::BusObserver bus(path);
  armsight::arm::BusFrame frame;
  while (is_stopping == 0 && bus.is_open())
    if (bus.receive(frame, std::chrono::milliseconds(200))) print("emulated", frame);
  return is_stopping != 0 ? 0 : 3;
}

int listen_to_interface(const std::string& name) {
  const auto clock = armsight::net::make_monotonic_clock(std::chrono::milliseconds(1));
  const auto bus = armsight::arm::open_socket_can(name, *clock, armsight::arm::CanHears::kEverything);
  const std::vector<int> descriptor{bus->descriptor()};
  armsight::arm::BusFrame frame;
  while (is_stopping == 0 && !bus->take_errors().lost) {
    while (bus->receive(frame)) print(name, frame);
    armsight::net::wait_and_flow(descriptor, std::chrono::milliseconds(200), nullptr);
  }
  return is_stopping != 0 ? 0 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  armsight::tools::CommandLine line("Prints a CAN bus live as candump -L text (for log2asc, canplayer, Wireshark).",
                                    "can_decode");
  std::string bus;
  std::string interface;
  line.add("--bus", bus, "emulated:PATH, the bus that arm_sim serves");
  line.add("--can", interface, "a CAN interface of this machine, e.g. can0");
  if (const auto code = line.parse(argc, argv)) return *code;
  const std::string prefix = "emulated:";
  if (bus.empty() == interface.empty() || (!bus.empty() && !bus.starts_with(prefix))) {
    std::fprintf(stderr, "can_decode: give --bus emulated:PATH or --can IFACE\n");
    return 2;
  }
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  try {
    return bus.empty() ? listen_to_interface(interface) : listen_to_emulated(bus.substr(prefix.size()));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "can_decode: %s\n", error.what());
    return 3;
  }
}
