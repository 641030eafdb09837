// write_samples FOLDER: sample.mcap, the same with a bit flipped in a chunk and in the summary, and traffic.log with a
// frame of every row of the CAN table, for the readers that are not ours.
#include <fstream>
#include <iostream>

#include "protocol/candump.hpp"
#include "sample_recording.hpp"

using namespace armsight;

namespace {

std::string flipped(std::string bytes, std::size_t at) {
  bytes[at] = static_cast<char>(bytes[at] ^ 1);
  return bytes;
}

std::string traffic() {
  const CanFrame frames[] = {encode(Nmt{NmtCommand::kStart, 0}), encode(Sync{1}), encode(Emcy{0x8611, 0x20}, 2),
                             encode(Tpdo1{0x1237, -2, -300}, 5), encode(Rpdo1{0x000F, -100000, 7}, 1),
                             encode(SdoRead{{0x6041, 0}}, 3), encode(SdoReadAnswer{{0x1000, 0}, 0x00020192, 4}, 3),
                             encode(SdoWrite{{0x1016, 1}, (127U << 16) | 250U, 4}, 3),
                             encode(SdoWriteAnswer{{0x1016, 1}}, 3), encode_answer_abort({{0x605A, 0}, 0x06090030}, 3),
                             encode_request_abort({{0x605A, 0}, 0x05040000}, 3),
                             encode(Heartbeat{NmtState::kBootUp}, 1), encode(Heartbeat{NmtState::kOperational}, 127)};
  std::string text;
  std::int64_t time_ns = 1'500'000'000;
  for (const CanFrame& frame : frames)
    text += to_candump({time_from_ns(time_ns += 250'000), "can0", frame, false}) + "\n";
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_samples FOLDER\n";
    return 2;
  }
  const std::string folder = argv[1], bytes = sample_recording();
  const auto save = [&](const char* name, const std::string& content) {
    std::ofstream(folder + "/" + name, std::ios::binary) << content;
  };
  save("sample.mcap", bytes);
  save("flipped-chunk.mcap", flipped(bytes, bytes.size() / 2));
  save("flipped-summary.mcap", flipped(bytes, bytes.size() - 100));
  save("traffic.log", traffic());
  return 0;
}
