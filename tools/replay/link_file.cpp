#include "tools/replay/link_file.hpp"

#include <algorithm>
#include <fstream>
#include <map>

namespace armsight::replay {
namespace {

template <typename Message>
Message parse(const RecordedMessage& recorded) {
  Message message;
  if (!message.ParseFromString(recorded.data))
    throw RecordingError("a message of " + recorded.topic + " is no " + recorded.message_type);
  return message;
}

void take(LinkFile& out, std::map<std::string, std::size_t>& open, wire::LinkRecord record) {
  const wire::Envelope& envelope = record.envelope();
  const auto found = open.find(record.peer());
  // A port may be used again: a first Hello begins another connection. A Stop beside it is answered before it.
  const bool is_first_hello = record.to_controller() && envelope.has_hello() && envelope.sequence() == 1;
  const bool is_new =
      found == open.end() || (is_first_hello && !out.connections[found->second].to_controller.empty());
  if (is_new) {
    open[record.peer()] = out.connections.size();
    Connection fresh;
    fresh.peer = record.peer();
    out.connections.push_back(std::move(fresh));
  }
  Connection& connection = out.connections[open[record.peer()]];
  if (record.to_controller() && envelope.has_hello() && connection.to_controller.empty()) {
    connection.program = envelope.hello().program();
    connection.participant = envelope.hello().sim_participant();
  }
  if (envelope.has_hello_reply()) connection.session = envelope.hello_reply().session();
  (record.to_controller() ? connection.to_controller : connection.from_controller).push_back(envelope);
  out.messages.push_back(std::move(record));
}

LinkFile load(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw RecordingError("cannot be read");
  RecordingReader reader(in);
  LinkFile out;
  std::map<std::string, std::size_t> open;
  for (RecordedMessage recorded; reader.next(recorded);) {
    if (recorded.topic == "/info") out.info = parse<wire::RecordingInfo>(recorded);
    if (recorded.topic == "/link") take(out, open, parse<wire::LinkRecord>(recorded));
  }
  if (!reader.is_complete()) throw RecordingError("its end is missing: cut while it was written or copied");
  if (out.messages.empty()) throw RecordingError("holds no message of the link (topic /link)");
  return out;
}

}  // namespace

LinkFile load_link_file(const std::filesystem::path& file) {
  try {
    return load(file);
  } catch (const RecordingError& error) {
    throw RecordingError(file.string() + ": " + error.what());
  }
}

}  // namespace armsight::replay
