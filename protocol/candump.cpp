#include "protocol/candump.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace armsight {

namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000, kErrorMask = 0x1FFFFFFF, kMaxStandardId = 0x7FF;
constexpr std::uint32_t kSwitchesRate = 1;  // CAN FD flags: the bit rate switch
constexpr std::size_t kMaxInterfaceName = 15;  // IFNAMSIZ of Linux
constexpr std::int64_t kMaxSeconds = 9'000'000'000;  // 9e18 ns still fit

template <typename T>
bool parse_all(std::string_view text, T& value, int base) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && text.front() != '-' && result.ec == std::errc() && result.ptr == text.data() + text.size();
}

bool parse_time(std::string_view text, Time& time) {
  const std::size_t dot = text.find('.');
  std::int64_t seconds = 0, microseconds = 0;
  if (dot == std::string_view::npos || text.size() - dot != 7) return false;
  if (!parse_all(text.substr(0, dot), seconds, 10) || !parse_all(text.substr(dot + 1), microseconds, 10)) return false;
  if (seconds > kMaxSeconds) return false;
  time = time_from_ns(seconds * 1'000'000'000 + microseconds * 1000);
  return true;
}

bool parse_data(std::string_view text, CanFrame& frame) {
  if (text.size() > 16 || text.size() % 2 != 0) return false;
  for (std::size_t i = 0; i < text.size() / 2; ++i)
    if (!parse_all(text.substr(2 * i, 2), frame.data[i], 16)) return false;
  frame.size = static_cast<std::uint8_t>(text.size() / 2);
  return true;
}

/// "" or why the frame's text is refused.
std::string parse_frame(std::string_view text, CandumpLine& line) {
  const std::size_t hash = text.find('#');
  if (hash == std::string_view::npos) return "no '#' between identifier and data";
  std::string_view data = text.substr(hash + 1);
  if (data.starts_with('#')) {  // CAN FD: a digit of flags before the data
    std::uint32_t flags = 0;
    if (data.size() < 2 || !parse_all(data.substr(1, 1), flags, 16)) return "a CAN FD frame needs its flags after '##'";
    if (data.size() > 2 + 16) return "CAN FD frame of more than 8 bytes: this arm uses none";
    line.frame.is_fd = true;
    data.remove_prefix(2);
  }
  if (data.starts_with('R') || data.starts_with('r')) return "remote frame: this arm uses none";
  std::uint32_t id = 0;
  if ((hash != 3 && hash != 8) || !parse_all(text.substr(0, hash), id, 16))
    return "the identifier must have 3 or 8 hexadecimal digits";
  line.is_error_frame = hash == 8 && (id & kErrorFlag) != 0;
  if (hash == 8 && !line.is_error_frame) return "29-bit identifier: this arm uses 11 bits";
  if (hash == 3 && id > kMaxStandardId) return "the identifier has more than 11 bits";
  line.frame.id = id & kErrorMask;
  if (!parse_data(data, line.frame)) return "the data must be 0 to 8 bytes of two hexadecimal digits";
  return "";
}

}  // namespace

std::string to_candump(const CandumpLine& line) {
  const std::int64_t time_us = std::max<std::int64_t>(to_ns(line.time), 0) / 1000;
  char head[64];
  std::snprintf(head, sizeof head, "(%010lld.%06lld) ", static_cast<long long>(time_us / 1'000'000),
                static_cast<long long>(time_us % 1'000'000));
  std::string out = head + line.interface;
  if (line.is_error_frame) std::snprintf(head, sizeof head, " %08X#", (line.frame.id & kErrorMask) | kErrorFlag);
  else if (line.frame.is_fd) std::snprintf(head, sizeof head, " %03X##%X", line.frame.id & kMaxStandardId, kSwitchesRate);
  else std::snprintf(head, sizeof head, " %03X#", line.frame.id & kMaxStandardId);
  out += head;
  for (std::size_t i = 0; i < std::min<std::size_t>(line.frame.size, 8); ++i) {
    std::snprintf(head, sizeof head, "%02X", line.frame.data[i]);
    out += head;
  }
  return out;
}

CandumpResult parse_candump(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
  CandumpLine line;
  const std::size_t close = text.find(") ");
  if (!text.starts_with('(') || close == std::string_view::npos || !parse_time(text.substr(1, close - 1), line.time))
    return {std::nullopt, "must begin with a time such as (1436509052.249713)"};
  text.remove_prefix(close + 2);
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space == 0 || space > kMaxInterfaceName)
    return {std::nullopt, "the interface must have 1 to 15 characters"};
  line.interface = text.substr(0, space);
  if (std::string why = parse_frame(text.substr(space + 1), line); !why.empty()) return {std::nullopt, why};
  return {line, ""};
}

}  // namespace armsight
