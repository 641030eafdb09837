// What a joint's drive speaks.
#pragma once

#include <cstdint>

namespace armsight {

/// CiA 301/402, or the MIT / DAMIAO frames (controller.md §4.6).
enum class DriveFamily : std::uint8_t { kCanopen, kDamiao };

}  // namespace armsight
