// A line of text as CAN traffic; what is taken must come back as it is, and every decoder must live with the frame.
#include <cstdlib>

#include "fuzz.hpp"
#include "protocol/candump.hpp"

using namespace armsight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const CandumpResult result = parse_candump({reinterpret_cast<const char*>(data), size});
  if (!result.line) return result.why.empty() ? (std::abort(), 0) : 0;
  const CandumpResult again = parse_candump(to_candump(*result.line));
  if (!again.line || !(again.line->frame == result.line->frame) || again.line->time != result.line->time) std::abort();
  const CanFrame& f = result.line->frame;
  const auto node = static_cast<std::uint8_t>(f.id & 0x7F);
  if (const auto m = decode_tpdo1(f, node); m && encode(*m, node) != f) std::abort();
  if (const auto m = decode_sdo_read_answer(f, node); m && (m->size < 1 || m->size > 4)) std::abort();
  decode_nmt(f), decode_sync(f), decode_emcy(f, node), decode_heartbeat(f, node), decode_sdo_write(f, node);
  return 0;
}
