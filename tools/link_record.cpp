// link_record: records the link of one host's visit from between host and controller; both need no change, and in
// lockstep their accounts stay between them. Exit codes: 0 either side ended the visit or Ctrl-C, 2 bad flag or file,
// 3 the controller cannot be reached or the disk is full.
#include <csignal>
#include <cstdio>

#include "protocol/config_error.hpp"
#include "tools/command_line.hpp"
#include "tools/replay/relay.hpp"

namespace {

int run(const armsight::replay::RelayOptions& options) {
  armsight::replay::Relay relay(options);
  const std::string& listen = options.listen_address;
  std::printf("link_record: listening on %s:%u\n", listen.substr(0, listen.rfind(':')).c_str(),
              static_cast<unsigned>(relay.port()));
  const auto messages = static_cast<unsigned long long>(relay.run());
  std::printf("link_record: %llu messages in %s\n", messages, options.file.c_str());
  return 0;
}

int fail(int code, const char* what) {
  std::fprintf(stderr, "link_record: %s\n", what);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  armsight::tools::CommandLine line(
      "Passes one host's link on to the arm controller, unchanged, and records both directions.", "link_record");
  armsight::replay::RelayOptions options;
  options.listen_address = "127.0.0.1:0";
  line.add("--arm", options.arm_address, "ADDR:PORT of the arm controller").required();
  line.add("--listen", options.listen_address, "ADDR:PORT for the host, loopback; port 0: chosen and printed")
      .show_default();
  line.add("--out", options.file, "the recording, an MCAP file").required();
  if (const auto code = line.parse(argc, argv)) return *code;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run(options);
  } catch (const armsight::ConfigError& error) {
    return fail(2, error.what());
  } catch (const std::exception& error) {
    return fail(3, error.what());
  }
}
