#include "arm_controller/several_buses.hpp"

#include <array>
#include <cassert>
#include <optional>
#include <utility>

#include "protocol/config.hpp"

namespace armsight::arm {
namespace {

class SeveralBuses final : public CanBus {
 public:
  explicit SeveralBuses(std::vector<std::unique_ptr<CanBus>> buses) : buses_(std::move(buses)) {
    for (const auto& bus : buses_) name_ += (name_.empty() ? "" : " + ") + bus->name();
  }

  SendResult send(const CanFrame& frame) noexcept override { return send_on(0, frame); }
  SendResult send_on(std::uint8_t bus, const CanFrame& frame) noexcept override {
    return bus < buses_.size() ? buses_[bus]->send(frame) : SendResult::kBusDown;
  }

  bool receive(BusFrame& frame) noexcept override {
    std::optional<std::size_t> first;
    for (std::size_t i = 0; i < buses_.size(); ++i) {
      if (!next_[i]) look_ahead(i);
      if (next_[i] && (!first || next_[i]->time < next_[*first]->time)) first = i;
    }
    if (!first) return false;
    frame = *std::exchange(next_[*first], std::nullopt);
    return true;
  }

  BusErrors take_errors() noexcept override {
    BusErrors all;
    all.lost = true;
    for (std::size_t i = 0; i < buses_.size(); ++i) {
      const BusErrors one = buses_[i]->take_errors();
      all.error_frames += one.error_frames;
      all.send_failures += one.send_failures;
      all.receive_overflows += one.receive_overflows;
      all.error_passive = all.error_passive || one.error_passive;
      all.bus_off = all.bus_off || one.bus_off;
      all.lost = all.lost && one.lost;
      if (one.lost) all.lost_buses = static_cast<std::uint8_t>(all.lost_buses | 1u << i);
      if (one.bus_off) all.bus_off_buses = static_cast<std::uint8_t>(all.bus_off_buses | 1u << i);
    }
    return all;
  }

  const std::string& name() const override { return name_; }

 private:
  void look_ahead(std::size_t i) noexcept {
    BusFrame frame;
    if (!buses_[i]->receive(frame)) return;
    frame.bus = static_cast<std::uint8_t>(i);
    next_[i] = frame;
  }

  std::vector<std::unique_ptr<CanBus>> buses_;
  std::array<std::optional<BusFrame>, kMaxBuses> next_;
  std::string name_;
};

}  // namespace

std::unique_ptr<CanBus> join_buses(std::vector<std::unique_ptr<CanBus>> buses) {
  assert(!buses.empty() && buses.size() <= kMaxBuses);
  if (buses.size() == 1) return std::move(buses.front());
  return std::make_unique<SeveralBuses>(std::move(buses));
}

}  // namespace armsight::arm
