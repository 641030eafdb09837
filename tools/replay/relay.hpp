// A host's bytes to the controller and back, unchanged, and beside them the messages that went by as a recording.
// Broken frames are forwarded too, for the receiver to judge; from then on that direction is no longer decoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

namespace armsight::replay {

struct RelayOptions {
  std::string arm_address, listen_address;  ///< "ADDR:PORT"; listening on loopback only
  std::filesystem::path file;
};

/// The controller cannot be reached: exit code 3.
class ArmUnreachable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Relay {
 public:
  /// Listens and opens the file; throws ConfigError "--flag value: rule".
  explicit Relay(const RelayOptions& options);
  ~Relay();
  std::uint16_t port() const;
  /// One host's visit; returns when either side ends it or SIGINT or SIGTERM came, with the file closed, and says how
  /// many messages it holds. Throws std::runtime_error where no host could connect or the file cannot be written.
  std::uint64_t run();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace armsight::replay
