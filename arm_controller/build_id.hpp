// Which executable this is: the build id that the linker wrote into it. Checkpoints are bytes of its own structures, so
// they mean something to the same executable only.
#pragma once

#include <string>

namespace armsight::arm {

/// Hexadecimal; empty where the executable carries none.
std::string build_id();

}  // namespace armsight::arm
