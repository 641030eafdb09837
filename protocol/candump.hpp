// CAN traffic as `candump -L` writes it: "(1436509052.249713) can0 044#2A366C2BBA", a line a frame. canplayer, log2asc
// and Wireshark read it. Microseconds; an error frame has eight digits with the flag 0x20000000.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "protocol/can_frames.hpp"
#include "shared/time.hpp"

namespace armsight {

struct CandumpLine {
  Time time;               ///< cut to microseconds; the format knows no time before 0
  std::string interface;   ///< "can0"
  CanFrame frame;          ///< of an error frame: id = error class bits of linux/can/error.h
  bool is_error_frame = false;
};

/// Without the line's end. Times before 0 are written as 0.
std::string to_candump(const CandumpLine& line);

struct CandumpResult {
  std::optional<CandumpLine> line;
  std::string why;  ///< if there is none: what was wrong, e.g. "29-bit identifier: this arm uses 11 bits"
};
/// Refuses what is not an 11-bit data frame of up to 8 bytes or an error frame: remote frames, 29 bits, broken text.
CandumpResult parse_candump(std::string_view text);

}  // namespace armsight
