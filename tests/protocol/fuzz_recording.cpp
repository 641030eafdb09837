// Any bytes as a recording, streamed and by index.
#include <sstream>

#include "fuzz.hpp"
#include "protocol/recording.hpp"

using namespace armsight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  try {
    std::istringstream in(bytes);
    RecordingReader reader(in);
    for (RecordedMessage message; reader.next(message);) {}
  } catch (const RecordingError&) {
  }
  try {
    std::istringstream in(bytes);
    const RecordingSummary summary = read_summary(in);
    read_messages(in, summary, {}, Time::min(), Time::max());
  } catch (const RecordingError&) {
  }
  return 0;
}
