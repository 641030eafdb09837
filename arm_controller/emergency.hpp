// What a drive's emergency message says, in words: CiA 301 error codes and the bits of the error register 0x1001.
#pragma once

#include <cstdint>
#include <string>

namespace armsight::arm {

/// Of the code itself, else of its group; "vendor-specific error" from 0xFF00 on.
const char* emergency_text(std::uint16_t code) noexcept;
/// "generic, communication"; "none" for 0. Allocates: not for the tick.
std::string error_register_text(std::uint8_t error_register);

}  // namespace armsight::arm
