// An arm of two drive families on two buses: some joints become DAMIAO drives on bus 1, in CAN FD.
#pragma once

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/system/quiet_arm.hpp"

namespace armsight::demo {

/// Rewrites the robot file: a copy of the demo's or the shipped one.
inline void make_damiao(const std::filesystem::path& file, const std::vector<int>& nodes) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  in.close();
  for (const int node : nodes) {
    const std::string id = std::to_string(node), old = "{node: " + id + ", counts_per_turn: 32768,";
    const std::size_t at = text.find(old);
    if (at == std::string::npos) throw std::runtime_error(file.string() + ": has no drive " + old);
    text.replace(at, old.size(),
                 "{family: damiao, node: " + id + ", reply_id: " + std::to_string(16 + node) +
                     ", bus: 1, fd: true,\n     position_range_rad: 12.5, speed_range_rad_s: 10, torque_range_Nm: 28,"
                     "\n     kp_Nm_rad: 80, kd_Nms_rad: 2,");
  }
  std::ofstream(file) << text;
}

struct BusShares {
  int classic_on_first = 0, fd_on_first = 0, fd_on_second = 0, classic_on_second = 0;
};
/// Every line that is not of the interface `first` is of the second.
inline BusShares count_frames(const std::vector<CandumpLine>& lines, const std::string& first) {
  BusShares out;
  for (const CandumpLine& line : lines) {
    const bool is_first = line.interface == first;
    out.classic_on_first += is_first && !line.frame.is_fd;
    out.fd_on_first += is_first && line.frame.is_fd;
    out.fd_on_second += !is_first && line.frame.is_fd;
    out.classic_on_second += !is_first && !line.frame.is_fd;
  }
  return out;
}

}  // namespace armsight::demo
