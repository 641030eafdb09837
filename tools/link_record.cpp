// link_record: records the link of one host's visit from between host and controller; both need no change, and in
// lockstep their accounts stay between them. Exit codes: 0 either side ended the visit or Ctrl-C, 2 bad flag or file,
// 3 the controller cannot be reached or the disk is full.
#include <csignal>
#include <cstdio>

#include "host/parse_flags.hpp"
#include "protocol/config_error.hpp"
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
  CLI::App app("Passes one host's link on to the arm controller, unchanged, and records both directions.",
               "link_record");
  armsight::replay::RelayOptions options;
  options.listen_address = "127.0.0.1:0";
  app.add_option("--arm", options.arm_address, "ADDR:PORT of the arm controller")->required();
  app.add_option("--listen", options.listen_address, "ADDR:PORT for the host, loopback; port 0: chosen and printed")
      ->capture_default_str();
  app.add_option("--out", options.file, "the recording, an MCAP file")->required();
  if (const auto code = armsight::host::parse_flags(app, argc, argv)) return *code;
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
