#include "arm_controller/black_box_input.hpp"

#include <cstring>
#include <type_traits>

#include "arm_controller/black_box_replay.hpp"
#include "arm_controller/can_bus.hpp"

namespace armsight::arm {
namespace {

constexpr std::size_t kMostBytes = 8;
constexpr std::uint32_t kHighestId = 0x7FF;

[[noreturn]] void refuse(const wire::CycleInput& in, const std::string& what) {
  throw NotReplayable("messages of cycle " + std::to_string(in.cycle()) + ": " + what);
}

/// Of an enumeration that counts from 0 up to `last`.
template <typename Enum>
bool is_one_of_them(Enum value, Enum last) {
  return static_cast<std::underlying_type_t<Enum>>(value) <= static_cast<std::underlying_type_t<Enum>>(last);
}

bool is_end_of_a_lease(std::uint32_t code) {
  for (const FaultCode known :
       {FaultCode::kLeaseSilent, FaultCode::kConnectionClosed, FaultCode::kLeaseReleased, FaultCode::kHostLeft})
    if (code == static_cast<std::uint32_t>(known)) return true;
  return false;
}

void check(const wire::CycleInput& in, const TickInbox& inbox, int joint_count) {
  if (inbox.look_count > kMaxLooks)
    refuse(in, std::to_string(inbox.look_count) + " looks, at most " + std::to_string(kMaxLooks));
  for (std::size_t i = 0; i < inbox.look_count; ++i)
    if (inbox.looks[i].measurement.q.size() != joint_count) refuse(in, "look without its angles");
  if (inbox.mode && !is_one_of_them(inbox.mode->wish, PowerWish::kHold)) refuse(in, "unknown wish");
  if (inbox.goal && !is_one_of_them(inbox.goal->kind, GoalKind::kPoseInCamera)) refuse(in, "unknown kind of goal");
  if (inbox.goal && inbox.goal->q_real_rad.size() != joint_count) refuse(in, "goal without its angles");
  if (inbox.goal && inbox.goal->commission_joint >= joint_count) refuse(in, "goal of a joint that is none");
  if (!inbox.proposal) return;
  const Eigen::Index state_size = kErrorBeta + joint_count;
  const Proposal& p = *inbox.proposal;
  const bool has_its_size = p.P.rows() == state_size && p.P.cols() == state_size;
  if (p.model.beta.size() != joint_count || (p.has_covariance && !has_its_size))
    refuse(in, "proposal of another number of joints");
}

}  // namespace

void check_frame(const wire::CanRecord& frame) {
  const auto refuse_frame = [](const std::string& what) { throw NotReplayable("a frame on /can: " + what); };
  if (frame.data().size() > kMostBytes) refuse_frame(std::to_string(frame.data().size()) + " bytes, at most 8");
  if (frame.id() > kHighestId) refuse_frame("identifier " + std::to_string(frame.id()) + ", at most 0x7FF");
  if (frame.send_result() > static_cast<std::uint32_t>(SendResult::kBusDown))
    refuse_frame("send_result = " + std::to_string(frame.send_result()) + ": unknown");
}

TickInbox inbox_of(const wire::CycleInput& in, int joint_count) {
  TickInbox inbox;
  if (!in.orders().empty()) {
    if (in.orders().size() != sizeof inbox) refuse(in, "wrong size");
    std::memcpy(static_cast<void*>(&inbox), in.orders().data(), sizeof inbox);
    check(in, inbox, joint_count);
  }
  inbox.stop = in.stop();
  inbox.model_not_saved = in.model_not_saved();
  inbox.lease.reset();
  if (!in.has_lease()) return inbox;
  if (!is_end_of_a_lease(in.lease_why_free()))
    refuse(in, "lease_why_free = " + std::to_string(in.lease_why_free()) + ": unknown");
  inbox.lease = Lease{in.lease_session(), time_from_ns(in.lease_until_ns()), time_from_ns(in.lease_heard_ns()),
                      static_cast<FaultCode>(in.lease_why_free())};
  return inbox;
}

}  // namespace armsight::arm
