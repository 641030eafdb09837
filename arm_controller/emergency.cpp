#include "arm_controller/emergency.hpp"

#include <array>

namespace armsight::arm {
namespace {

struct CodeText {
  std::uint16_t code;
  std::uint16_t mask;  ///< of the bits that must agree
  const char* text;
};

// From the particular to the general: the first that fits (CiA 301 table of error code groups, CiA 402 codes).
constexpr std::array kTexts{
    CodeText{0x0000, 0xFF00, "no error, or error reset"},
    CodeText{0x2310, 0xFFFF, "over-current"},
    CodeText{0x2320, 0xFFFF, "short circuit"},
    CodeText{0x3210, 0xFFFF, "DC link over-voltage"},
    CodeText{0x3220, 0xFFFF, "DC link under-voltage"},
    CodeText{0x4210, 0xFFFF, "device too hot"},
    CodeText{0x4310, 0xFFFF, "drive too hot"},
    CodeText{0x6320, 0xFFFF, "parameter error"},
    CodeText{0x7305, 0xFFFF, "incremental encoder error"},
    CodeText{0x7300, 0xFF00, "sensor error"},
    CodeText{0x8110, 0xFFFF, "CAN overrun: frames lost"},
    CodeText{0x8120, 0xFFFF, "CAN error passive"},
    CodeText{0x8130, 0xFFFF, "heartbeat or life guard lost"},
    CodeText{0x8140, 0xFFFF, "recovered from bus-off"},
    CodeText{0x8150, 0xFFFF, "CAN identifier collision"},
    CodeText{0x8210, 0xFFFF, "PDO not processed: wrong length"},
    CodeText{0x8220, 0xFFFF, "PDO too long"},
    CodeText{0x8240, 0xFFFF, "unexpected SYNC length"},
    CodeText{0x8250, 0xFFFF, "set-points missing: RPDO deadline passed"},
    CodeText{0x8611, 0xFFFF, "following error too large"},
    CodeText{0x8612, 0xFFFF, "reference beyond its limit"},
    CodeText{0x1000, 0xF000, "generic error"},
    CodeText{0x2000, 0xF000, "current"},
    CodeText{0x3000, 0xF000, "voltage"},
    CodeText{0x4000, 0xF000, "temperature"},
    CodeText{0x5000, 0xF000, "device hardware"},
    CodeText{0x6000, 0xF000, "device software"},
    CodeText{0x7000, 0xF000, "additional modules"},
    CodeText{0x8100, 0xFF00, "communication"},
    CodeText{0x8000, 0xF000, "monitoring"},
    CodeText{0x9000, 0xF000, "external error"},
    CodeText{0xF000, 0xFF00, "additional functions"},
    CodeText{0xFF00, 0xFF00, "vendor-specific error"},
};

constexpr std::array<const char*, 8> kRegisterBits{"generic", "current", "voltage", "temperature",
                                                   "communication", "device profile", "reserved", "vendor"};

}  // namespace

const char* emergency_text(std::uint16_t code) noexcept {
  for (const CodeText& one : kTexts)
    if ((code & one.mask) == one.code) return one.text;
  return "unknown error code";
}

std::string error_register_text(std::uint8_t error_register) {
  std::string text;
  for (std::size_t bit = 0; bit < kRegisterBits.size(); ++bit)
    if ((error_register >> bit & 1) != 0) text += (text.empty() ? "" : ", ") + std::string(kRegisterBits[bit]);
  return text.empty() ? "none" : text;
}

}  // namespace armsight::arm
