// Row 1: a peer that sends anything but the protocol at the live port, while the arm holds under somebody's command.
// Nothing crashes, no large piece of memory is asked for, and the arm's state stays what it was. In full: label soak.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <cstdlib>

#include "protocol/descriptor.hpp"
#include "protocol/little_endian.hpp"
#include "tests/faults/linked_rig.hpp"
#include "tools/sim/random.hpp"

namespace armsight::faults {
namespace {

constexpr std::size_t kMostAtOnce = 256 * 1024;

/// A socket and no manners.
class RawPeer {
 public:
  explicit RawPeer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  void send(const std::string& bytes) {
    ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }

 private:
  Descriptor socket_;
};

class HostilePeer : public ::testing::Test {
 protected:
  LinkedRig rig;
  sim::Random random{1, 910};
  std::unique_ptr<Peer> commander = rig.powered_commander();

  std::string noise(std::size_t size) {
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.bits());
    return bytes;
  }
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random.unit() * static_cast<double>(limit)); }
  static std::string header(std::uint32_t size) {
    std::string bytes = wire::encode_frame(wire::FrameType::kLink, {});
    write_le<std::uint32_t>(bytes.data() + 4, size);
    return bytes;
  }
  /// A message that would do something, but for its sender.
  wire::Envelope command() {
    wire::Envelope e;
    switch (below(5)) {
      case 0: e = rig.hello(wire::ROLE_COMMAND); break;
      case 1: e.mutable_lease_request(); break;
      case 2: e = LinkedRig::joint_goal(FaultRig::far_goal()); break;
      case 3: e.mutable_mode_request()->set_mode(wire::MODE_READY); break;
      default: e = rig.pose_goal(FaultRig::far_goal());
    }
    e.set_protocol_version(wire::kProtocolVersion);
    e.set_session(random.bits());
    e.set_sequence(random.bits());
    return e;
  }
  std::string attack() {
    const std::string whole = command().SerializeAsString();
    switch (below(6)) {
      case 0: return noise(1 + below(3000));
      case 1: return header(static_cast<std::uint32_t>(random.bits())) + noise(below(4000));
      case 2: return wire::encode_frame(wire::FrameType::kLink, noise(below(4096)));
      case 3: return wire::encode_frame(wire::FrameType::kLink, whole).substr(0, below(whole.size() + 8));
      case 4: return wire::encode_frame(wire::FrameType::kLink, whole);
      default: {
        std::string bent = whole;
        for (std::size_t i = 0; i <= below(8); ++i) bent[below(bent.size())] ^= static_cast<char>(1 << below(8));
        return wire::encode_frame(wire::FrameType::kLink, bent);
      }
    }
  }
  void expect_unmoved(Time since) {
    EXPECT_LT(rig.travelled_rad(since), kCount_rad);
    EXPECT_TRUE(rig.all_drives(DriveState::kOperationEnabled));
    EXPECT_LE(rig.take_largest_allocation(), kMostAtOnce);
    commander->take();
    commander->send(LinkedRig::joint_goal(FaultRig::far_goal()));
    rig.cycles(60);
    EXPECT_GT(rig.fastest_rad_s(), 0.3) << "its host commands as before";
  }
};

TEST_F(HostilePeer, MovesNothingWhateverItSends) {
  const bool is_soak = std::getenv("ARMSIGHT_SOAK") != nullptr;
  rig.take_largest_allocation();
  const Time began = rig.now;
  for (int i = 0; i < (is_soak ? 100'000 : 400); ++i) {
    RawPeer peer(rig.link->port());
    for (std::size_t k = 0; k <= below(4); ++k) peer.send(attack());
    rig.cycle();
    if (i % 100 == 0) commander->take();
    if (i % 1000 != 999) continue;
    ASSERT_LT(rig.travelled_rad(rig.truth.front().time), 0.1);
    rig.log.clear();  // a long run does not fill the machine
  }
  expect_unmoved(began);
}

TEST_F(HostilePeer, AnnouncingAHugeFrameGetsNoMemory) {
  rig.take_largest_allocation();
  const Time began = rig.now;
  RawPeer peer(rig.link->port());
  peer.send(header(64u << 20));
  for (int i = 0; i < 40; ++i) {
    peer.send(noise(64 * 1024));
    rig.cycle();
  }
  expect_unmoved(began);
}

/// A Hello that says it is 200 MB long, with an unknown field of 40 MB: the frame is within its limit.
TEST_F(HostilePeer, AnnouncingAHugeFieldGetsNoMemory) {
  const auto field = [](unsigned number, std::uint32_t size) {
    std::string bytes;
    for (std::uint64_t value : {std::uint64_t{number} << 3 | 2, std::uint64_t{size}}) {
      for (; value > 0x7F; value >>= 7) bytes += static_cast<char>(value | 0x80);
      bytes += static_cast<char>(value);
    }
    return bytes;
  };
  rig.take_largest_allocation();
  const Time began = rig.now;
  RawPeer peer(rig.link->port());
  const std::string payload = field(wire::Envelope::kHelloFieldNumber, 200u << 20) + field(99, 40u << 20) + noise(300);
  peer.send(wire::encode_frame(wire::FrameType::kLink, payload));
  rig.cycles(5);
  expect_unmoved(began);
}

}  // namespace
}  // namespace armsight::faults
