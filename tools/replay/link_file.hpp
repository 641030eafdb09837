// The link as a recording holds it: who spoke with the controller, and what both said, in order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"

namespace armsight::replay {

/// One host's connection, from its Hello on. Times in the envelopes are each sender's own.
struct Connection {
  std::string peer;                        ///< "127.0.0.1:40312"
  std::string program;                     ///< as its Hello says; empty where a peer never said Hello
  std::uint32_t participant = 0;           ///< of the simulated clock
  std::uint64_t session = 0;               ///< as the controller named it; 0: it never did
  std::vector<wire::Envelope> to_controller, from_controller;
};

struct LinkFile {
  std::optional<wire::RecordingInfo> info;
  std::vector<Connection> connections;     ///< in order of their first message
  std::vector<wire::LinkRecord> messages;  ///< all of them, in order of the file
};

/// Throws RecordingError "FILE: what and where" on a damaged, cut or foreign file and on one without link messages.
LinkFile load_link_file(const std::filesystem::path& file);

}  // namespace armsight::replay
