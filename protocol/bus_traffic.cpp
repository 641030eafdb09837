#include "protocol/bus_traffic.hpp"

#include <algorithm>
#include <array>

namespace armsight {

namespace {

constexpr std::int64_t kWindow_ns = 100'000'000;

int bits_of(const CanFrame& frame) {
  if (!frame.is_fd) return stuffed_bits(frame);
  const FdBits bits = worst_case_fd_bits(frame.size);
  return bits.arbitration + bits.data;
}

}  // namespace

int stuffed_bits(const CanFrame& frame) noexcept {
  constexpr int kHead = 19, kCrcBits = 15, kTail = 13;  // tail: both delimiters, acknowledge, end, space; unstuffed
  std::array<bool, kHead + 64 + kCrcBits> bits{};
  int count = 0;
  std::uint16_t crc = 0;
  const auto put = [&](bool bit) { bits[static_cast<std::size_t>(count++)] = bit; };
  const auto put_all = [&](std::uint32_t value, int width) {
    for (int i = width - 1; i >= 0; --i) put((value >> i & 1) != 0);
  };
  put_all(0, 1);              // start of frame
  put_all(frame.id, 11);
  put_all(0, 3);              // data frame, 11-bit identifier, reserved
  put_all(frame.size, 4);
  for (int i = 0; i < frame.size; ++i) put_all(frame.data[static_cast<std::size_t>(i)], 8);
  for (int i = 0; i < count; ++i) {
    const bool differs = bits[static_cast<std::size_t>(i)] != ((crc >> 14 & 1) != 0);
    crc = static_cast<std::uint16_t>(crc << 1 & 0x7FFF);
    if (differs) crc ^= 0x4599;
  }
  put_all(crc, kCrcBits);
  int stuffed = 0, run = 0;
  bool last = true;           // the bus was idle
  for (int i = 0; i < count; ++i) {
    const bool bit = bits[static_cast<std::size_t>(i)];
    run = bit == last && i > 0 ? run + 1 : 1;
    last = bit;
    if (run < 5) continue;
    ++stuffed;                // the opposite bit follows and begins the next run
    last = !bit;
    run = 1;
  }
  return count + stuffed + kTail;
}

void BusTraffic::add(const CanFrame& frame, Time end) {
  const int bits = bits_of(frame);
  const double worst_s = worst_case_s(frame.size, frame.is_fd, rates_);
  const double wire_s = frame.is_fd ? worst_s : bits / rates_.bitrate_bit_s;
  if (!first_) {
    first_ = end;  // its own bits lie before the time that is looked at
  } else {
    SeenMessage& seen = messages_[frame.id];
    ++seen.count;
    seen.bits += bits;
    seen.most_bits = std::max(seen.most_bits, bits);
    seen.wire_s += wire_s;
    seen.worst_case_s += worst_s;
    const std::int64_t window = (to_ns(end) - to_ns(*first_)) / kWindow_ns;
    window_s_ = window == window_ ? window_s_ + wire_s : wire_s;
    window_ = window;
    highest_load_ = std::max(highest_load_, window_s_ / (1e-9 * kWindow_ns));
  }
  last_ = end;
  if (frame.id == kSyncId) sync_begin_ = end - seconds_to_duration(worst_s);
  if (!sync_begin_) return;
  std::optional<double>& latest_s = messages_[frame.id].latest_s;
  latest_s = std::max(latest_s.value_or(0.0), to_seconds(end - *sync_begin_));
}

double BusTraffic::duration_s() const { return first_ ? to_seconds(*last_ - *first_) : 0.0; }

double BusTraffic::load() const {
  double wire_s = 0.0;
  for (const auto& [id, seen] : messages_) wire_s += seen.wire_s;
  return duration_s() > 0.0 ? wire_s / duration_s() : 0.0;
}

double BusTraffic::worst_case_load() const {
  double worst_s = 0.0;
  for (const auto& [id, seen] : messages_) worst_s += seen.worst_case_s;
  return duration_s() > 0.0 ? worst_s / duration_s() : 0.0;
}

}  // namespace armsight
