#include "protocol/transport/sim_clock.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "protocol/sim_clock.pb.h"
#include "protocol/transport/framed_stream.hpp"
#include "protocol/transport/lockstep_account.hpp"
#include "protocol/transport/monotonic_clock.hpp"
#include "protocol/transport/wait.hpp"

namespace armsight::net {

namespace {

StreamOptions clock_stream_options() {
  return {wire::FrameType::kSimClock, wire::kMaxSimClock, wire::kMaxSimClock, 1024 * 1024};
}

/// The stream to arm_sim needs a clock only for arrival times, which nobody reads.
Clock& timeless() {
  static MonotonicClock clock(Crystal{}, std::chrono::milliseconds(1));
  return clock;
}

void fill(const std::map<ChannelKey, std::uint64_t>& totals,
          google::protobuf::RepeatedPtrField<wire::ChannelCount>& out) {
  for (const auto& [channel, total] : totals) {
    wire::ChannelCount& count = *out.Add();
    count.set_kind(static_cast<wire::ChannelKind>(channel.kind));
    count.set_peer(channel.peer);
    count.set_total(total);
  }
}

class SimClock : public SimConductor {
 public:
  SimClock(const std::string& path, const std::string& name, int role, Duration period)
      : stream_(connect_unix(path, clock_stream_options(), timeless())) {
    wire::SimClockMessage message;
    message.mutable_join()->set_name(name);
    message.mutable_join()->set_role(static_cast<wire::SimRole>(role));
    send(message);
    welcome_ = next_message().welcome();
    require_period(role, period);
    std::fprintf(stderr, "%s: joined the simulated clock\n", name.c_str());
    if (is_lockstep()) {
      take_grant();
    } else {
      real_.emplace(Crystal{welcome_.clock_offset_ns(), welcome_.clock_skew_ppb()}, period);
    }
  }

  ~SimClock() override {
    if (!stream_->is_open()) return;
    wire::SimClockMessage message;
    if (is_lockstep()) fill_done(*message.mutable_leave()->mutable_last());
    else message.mutable_leave();
    stream_->send(message.SerializeAsString());
  }

  Time now() const override { return real_ ? real_->now() : now_; }

  Time wait_next_cycle() override {
    if (real_) return real_->wait_next_cycle();
    wire::SimClockMessage message;
    fill_done(*message.mutable_done());
    send(message);
    take_grant();
    return now_;
  }

  bool is_lockstep() const override { return welcome_.pace() == wire::SIM_PACE_LOCKSTEP; }
  std::uint64_t missed() const override { return real_ ? real_->missed() : 0; }
  Duration lateness() const override { return real_ ? real_->lateness() : Duration{}; }

  void count_sent(ChannelKey channel) override {
    if (!real_) account_.count_sent(channel);
  }
  void count_received(ChannelKey channel) override {
    if (!real_) account_.count_received(channel);
  }
  std::span<const Time> due(ChannelKey channel) const override { return account_.due(channel); }
  std::span<const ChannelKey> due_channels(ChannelKind kind) const override { return account_.due_channels(kind); }
  std::uint32_t participant() const override { return welcome_.participant(); }
  std::uint32_t arm_controller() const override { return arm_controller_; }

  void add_flow(Flow* flow) override {
    if (!real_) flows_.push_back(flow);
  }
  void remove_flow(Flow* flow) override {
    if (!real_) std::erase(flows_, flow);
  }
  std::span<Flow* const> flows() const override { return flows_; }

  void inject_drift() override {
    wire::SimClockMessage message;
    message.mutable_inject_drift();
    ask(message);
  }

  void finish(const std::string& truth_file) override {
    wire::SimClockMessage message;
    message.mutable_finish()->set_truth_file(truth_file);
    ask(message);
  }

 private:
  void require_period(int role, Duration period) const {
    if (!is_lockstep() || role != wire::SIM_ROLE_ARM_CONTROLLER || welcome_.period_ns() == period.count()) return;
    throw std::runtime_error("arm_sim runs cycles of " + std::to_string(welcome_.period_ns()) + " ns, the controller " +
                             std::to_string(period.count()) + " ns: both must have the same rate");
  }

  void send(const wire::SimClockMessage& message) {
    if (!stream_->send(message.SerializeAsString())) throw ClockLost();
  }

  wire::SimClockMessage next_message() {
    const int descriptors[] = {stream_->descriptor()};
    while (queue_.empty()) {
      if (!stream_->is_open()) throw ClockLost();
      wait_and_flow(descriptors, Duration{-1}, this);
      queue_ = stream_->receive();
      std::reverse(queue_.begin(), queue_.end());
    }
    wire::SimClockMessage message;
    const bool is_sound = message.ParseFromString(queue_.back().payload);
    queue_.pop_back();
    if (!is_sound) throw ClockLost();
    return message;
  }

  void take_grant() {
    const wire::SimClockMessage message = next_message();
    if (!message.has_grant()) throw ClockLost();
    const wire::Grant& grant = message.grant();
    cycle_ = grant.cycle();
    now_ = time_from_ns(grant.time_ns());
    arm_controller_ = grant.arm_controller();
    account_.begin_cycle();
    for (const wire::Arrivals& arrivals : grant.arrivals())
      for (const std::int64_t time_ns : arrivals.time_ns())
        account_.add_due({static_cast<ChannelKind>(arrivals.kind()), arrivals.peer()}, time_from_ns(time_ns));
    account_.finish_grant();
  }

  void fill_done(wire::Done& done) const {
    done.set_cycle(cycle_);
    fill(account_.sent(), *done.mutable_sent());
    fill(account_.received(), *done.mutable_received());
  }

  void ask(const wire::SimClockMessage& question) {
    send(question);
    const wire::SimClockMessage answer = next_message();
    if (!answer.has_ok()) throw ClockLost();
    if (!answer.ok().error().empty()) throw std::runtime_error(answer.ok().error());
  }

  std::unique_ptr<FramedStream> stream_;
  std::vector<Received> queue_;  ///< newest first
  wire::Welcome welcome_;
  std::optional<MonotonicClock> real_;
  LockstepAccount account_;
  std::vector<Flow*> flows_;
  std::uint64_t cycle_ = 0;
  Time now_;
  std::uint32_t arm_controller_ = 0;
};

}  // namespace

std::unique_ptr<Clock> join_sim_clock(const std::string& path, const std::string& name, int role, Duration period) {
  return std::make_unique<SimClock>(path, name, role, period);
}

std::unique_ptr<SimConductor> join_as_conductor(const std::string& path, const std::string& name, Duration period) {
  return std::make_unique<SimClock>(path, name, wire::SIM_ROLE_CONDUCTOR, period);
}

}  // namespace armsight::net
