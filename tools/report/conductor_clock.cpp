// The conductor's side of arm_sim's clock: joining it, holding and releasing cycles, its wishes.
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "protocol/sim_clock.pb.h"
#include "tools/report/conductor.hpp"
#include "tools/report/patience.hpp"

namespace armsight::demo {

void Conductor::join_clock(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path) throw ProgramLost("socket path too long: " + path.string());
  std::memcpy(address.sun_path, path.c_str(), path.string().size() + 1);
  clock_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(clock_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw ProgramLost("cannot join the simulated clock at " + path.string() + ": " + std::strerror(errno));
  }
  wire::SimClockMessage message;
  message.mutable_join()->set_name("demo");
  message.mutable_join()->set_role(wire::SIM_ROLE_CONDUCTOR);
  send(message);
  const Patience patience(kStartPatience_ms);
  while (!is_welcome_) {
    attend(kPoll_ms);
    if (patience.is_over()) throw ProgramLost("arm_sim does not answer on its clock");
  }
  hold();
}

void Conductor::inject_drift() {
  wire::SimClockMessage message;
  message.mutable_inject_drift();
  request(message, "the drift");
}

void Conductor::finish(const std::filesystem::path& truth_file) {
  servers_.clear();  // without a clock they end
  wire::SimClockMessage message;
  message.mutable_finish()->set_truth_file(truth_file.string());
  request(message, "the truth");
}

double Conductor::time_s() const {
  if (is_lockstep_) return static_cast<double>(cycle_) * period_s_;
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Conductor::request(const wire::SimClockMessage& message, const std::string& what) {
  hold();
  is_answered_ = false;
  send(message);
  const Patience patience(kStartPatience_ms);
  while (!is_answered_) {
    if (patience.is_over() || is_clock_lost_) throw ProgramLost("arm_sim does not answer when asked for " + what);
    attend(kPoll_ms);
  }
  if (!answer_error_.empty()) throw std::runtime_error("arm_sim refused " + what + ": " + answer_error_);
}

void Conductor::hold() {
  if (!is_lockstep_ || clock_ < 0) return;
  const Patience patience(60'000);
  while (!is_grant_pending_) {
    attend(kPoll_ms);
    if (patience.is_over()) throw ProgramLost("the simulated clock stands still since cycle " + std::to_string(cycle_));
  }
}

void Conductor::release() {
  if (!is_grant_pending_) return;
  is_grant_pending_ = false;
  wire::SimClockMessage message;
  message.mutable_done()->set_cycle(cycle_);
  send(message);
}

void Conductor::send(const wire::SimClockMessage& message) {
  const std::string frame = wire::encode_frame(wire::FrameType::kSimClock, message.SerializeAsString());
  for (std::size_t sent = 0; sent < frame.size();) {
    const ssize_t n = ::send(clock_, frame.data() + sent, frame.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      is_clock_lost_ = true;
      return;  // attend() says which program is gone
    }
    sent += static_cast<std::size_t>(n);
  }
}

void Conductor::take_clock_messages() {
  std::array<char, 4096> bytes{};
  const ssize_t n = recv(clock_, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (n < 0) return;
  std::vector<std::string> payloads;
  if (n == 0 || !decoder_.feed({bytes.data(), static_cast<std::size_t>(n)}, payloads)) is_clock_lost_ = true;
  for (const std::string& payload : payloads) {
    wire::SimClockMessage message;
    if (!message.ParseFromString(payload)) continue;
    if (message.has_welcome()) {
      is_welcome_ = true;
      period_s_ = 1e-9 * static_cast<double>(message.welcome().period_ns());
      is_lockstep_ = message.welcome().pace() == wire::SIM_PACE_LOCKSTEP;
    } else if (message.has_grant()) {
      is_grant_pending_ = true;
      cycle_ = message.grant().cycle();
      participants_ = message.grant().participants();
    } else if (message.has_ok()) {
      is_answered_ = true;
      answer_error_ = message.ok().error();
    }
  }
}

}  // namespace armsight::demo
