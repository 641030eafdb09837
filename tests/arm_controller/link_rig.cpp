#include "tests/arm_controller/link_rig.hpp"

#include <stdlib.h>

#include <numbers>

#include "arm_controller/state_folder.hpp"

namespace armsight::arm::test {
namespace {

std::filesystem::path temporary_folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "arm_rig_XXXXXX").string();
  return ::mkdtemp(pattern.data());
}

}  // namespace

wire::Envelope hello_of(const RobotConfig& robot, wire::Role role) {
  wire::Envelope envelope;
  wire::Hello& hello = *envelope.mutable_hello();
  hello.set_protocol_version(wire::kProtocolVersion);
  hello.set_program("test");
  hello.set_model_hash(model_hash(robot));
  hello.set_role(role);
  return envelope;
}

bool is_answer_to(std::uint64_t sequence, const wire::Envelope& e) {
  return (e.has_accepted() && e.accepted().accepted_sequence() == sequence) ||
         (e.has_refusal() && e.refusal().refused_sequence() == sequence);
}

LinkRig::LinkRig() : folder(temporary_folder()) {
  for (int i = 1; i <= 5; ++i) bus.drive(i).position_counts = 0.1 * i / (2.0 * std::numbers::pi) * 32768.0;
  const StartModel start = load_model_in_force(folder, robot);
  files = std::make_unique<FileWriter>(folder, robot, "emulated", "", tape);
  files->begin(clock.now());
  link = std::make_unique<LinkServer>("127.0.0.1:0", robot, "emulated", mailboxes, statistics, *files, clock);
  loop = std::make_unique<ControlLoop>(robot, start, bus, mailboxes, tape, statistics);
}

LinkRig::~LinkRig() {
  link.reset();
  files.reset();
  std::filesystem::remove_all(folder);
}

void LinkRig::cycle() {
  clock.time += seconds_to_duration(robot.controller.period_s);
  bus.now = clock.time;
  link->step(clock.time);
  loop->cycle(clock.time, 0);
  files->wait_idle();
  link->publish(clock.time);
}

std::optional<wire::Envelope> LinkRig::wait_for(Peer& peer, const std::function<bool(const wire::Envelope&)>& fits,
                                                int at_most) {
  for (int i = 0; i < at_most; ++i) {
    if (peer.session != 0 && i % 12 == 0) {
      wire::Envelope beat;
      beat.mutable_heartbeat();
      peer.send(beat);
    }
    cycle();
    for (const wire::Envelope& envelope : peer.take())
      if (fits(envelope)) return envelope;
  }
  return std::nullopt;
}

wire::Envelope LinkRig::answer_to(Peer& peer, std::uint64_t sequence) {
  const auto found = wait_for(peer, [sequence](const wire::Envelope& e) { return is_answer_to(sequence, e); }, 100);
  EXPECT_TRUE(found) << "no answer to " << sequence;
  return found.value_or(wire::Envelope{});
}

std::unique_ptr<Peer> LinkRig::commander() {
  auto peer = std::make_unique<Peer>(link->port(), clock);
  peer->send(hello(wire::ROLE_COMMAND));
  EXPECT_TRUE(wait_for(*peer, [](const auto& e) { return e.has_hello_reply(); }));
  wire::Envelope lease;
  lease.mutable_lease_request();
  EXPECT_TRUE(answer_to(*peer, peer->send(lease)).has_accepted());
  return peer;
}

std::unique_ptr<Peer> LinkRig::powered_commander() {
  auto peer = commander();
  EXPECT_TRUE(
      wait_for(*peer, [](const auto& e) { return e.has_arm_state() && e.arm_state().mode() == wire::MODE_READY; }));
  wire::Envelope hold;
  hold.mutable_mode_request()->set_mode(wire::MODE_HOLD);
  EXPECT_TRUE(answer_to(*peer, peer->send(hold)).has_accepted());
  EXPECT_TRUE(
      wait_for(*peer, [](const auto& e) { return e.has_arm_state() && e.arm_state().mode() == wire::MODE_HOLD; }));
  return peer;
}

}  // namespace armsight::arm::test
