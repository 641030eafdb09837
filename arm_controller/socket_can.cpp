#include "arm_controller/socket_can.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "protocol/descriptor.hpp"

namespace armsight::arm {
namespace {

std::string reason() { return std::strerror(errno); }

template <typename T>
void set_option(int fd, int level, int option, const T& value, const char* what) {
  if (::setsockopt(fd, level, option, &value, sizeof value) != 0)
    throw BusError(std::string("CAN socket option ") + what + ": " + reason());
}

std::int64_t clock_ns(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return 1'000'000'000LL * t.tv_sec + t.tv_nsec;
}

/// Answers and samples of nodes 1 … 127 (those of DAMIAO drives come as 1 … 126), emergencies, heartbeats, and our own
/// SYNC back.
void set_filters(int fd) {
  constexpr canid_t kAnyNode = CAN_EFF_FLAG | CAN_RTR_FLAG | (CAN_SFF_MASK & ~0x7Fu);
  const std::array<can_filter, 6> filters{{{0x000, kAnyNode},
                                           {kSyncId, kAnyNode},
                                           {kTpdo1Base, kAnyNode},
                                           {kSdoAnswerBase, kAnyNode},
                                           {kHeartbeatBase, kAnyNode},
                                           {0x280, kAnyNode}}};
  set_option(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters, "CAN_RAW_FILTER");
}

class SocketCan final : public CanBus {
 public:
  SocketCan(int fd, const std::string& interface, net::Clock& clock)
      : fd_(fd), name_("socketcan:" + interface), clock_(clock) {}

  SendResult send(const CanFrame& frame) noexcept override {
    canfd_frame raw{};  // the kernel tells the two by their size; they begin alike
    raw.can_id = frame.id;
    raw.len = frame.size;
    if (frame.is_fd) raw.flags = CANFD_BRS;
    std::copy(frame.data.begin(), frame.data.end(), raw.data);
    const std::size_t size = frame.is_fd ? CANFD_MTU : CAN_MTU;
    if (::write(fd_.get(), &raw, size) == static_cast<ssize_t>(size)) return SendResult::kSent;
    ++errors_.send_failures;
    if (errno == ENOBUFS || errno == EAGAIN) return SendResult::kQueueFull;
    if (errno == ENODEV || errno == ENXIO) errors_.lost = true;
    return SendResult::kBusDown;
  }

  bool receive(BusFrame& frame) noexcept override {
    canfd_frame raw;
    Time time;
    bool is_own = false, is_fd = false;
    while (read_one(raw, time, is_own, is_fd)) {
      if (raw.can_id & CAN_ERR_FLAG) {
        note_error(raw);
        continue;
      }
      if (raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) continue;  // nobody of ours speaks so
      if (raw.len > 8) continue;
      frame.frame.id = raw.can_id & CAN_SFF_MASK;
      frame.frame.size = raw.len;
      frame.frame.is_fd = is_fd;
      std::copy_n(raw.data, frame.frame.data.size(), frame.frame.data.begin());
      frame.time = time;
      frame.is_own_echo = is_own;
      return true;
    }
    clocks_are_read_ = false;
    return false;
  }

  BusErrors take_errors() noexcept override {
    const BusErrors taken = errors_;
    errors_ = {};
    errors_.lost = taken.lost;
    return taken;
  }

  const std::string& name() const override { return name_; }
  int descriptor() const noexcept override { return fd_.get(); }

 private:
  bool read_one(canfd_frame& raw, Time& time, bool& is_own, bool& is_fd) noexcept;
  void note_error(const canfd_frame& raw) noexcept;
  void read_clocks() noexcept;
  Time own_time(const msghdr& message) noexcept;

  Descriptor fd_;
  std::string name_;
  net::Clock& clock_;
  BusErrors errors_;
  std::uint32_t kernel_overflows_ = 0;
  bool clocks_are_read_ = false;  ///< once for all frames that wait
  Time own_now_{};
  std::int64_t wall_now_ns_ = 0;
};

/// A classic frame fills the first 16 bytes of an FD one, error frames do on every socket.
bool SocketCan::read_one(canfd_frame& raw, Time& time, bool& is_own, bool& is_fd) noexcept {
  alignas(cmsghdr) char control[256];
  iovec part{&raw, sizeof raw};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = ::recvmsg(fd_.get(), &message, MSG_DONTWAIT);
  if (size < 0 && (errno == ENETDOWN || errno == ENODEV)) errors_.lost = true;
  if (size != static_cast<ssize_t>(CAN_MTU) && size != static_cast<ssize_t>(CANFD_MTU)) return false;
  is_fd = size == static_cast<ssize_t>(CANFD_MTU);
  is_own = (message.msg_flags & MSG_CONFIRM) != 0;  // set by the kernel on frames of this very socket
  time = own_time(message);
  return true;
}

void SocketCan::read_clocks() noexcept {
  if (clocks_are_read_) return;
  own_now_ = clock_.now();
  wall_now_ns_ = clock_ns(CLOCK_REALTIME);
  clocks_are_read_ = true;
}

// Kernel stamps are wall clock, and wall clocks step: the age of the stamp, taken now, is what is used. A frame that
// came after the clocks were read has a small negative age.
Time SocketCan::own_time(const msghdr& message) noexcept {
  read_clocks();
  std::int64_t age_ns = 0;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(const_cast<msghdr*>(&message), c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_TIMESTAMPNS) {
      timespec t{};
      std::memcpy(&t, CMSG_DATA(c), sizeof t);
      age_ns = wall_now_ns_ - (1'000'000'000LL * t.tv_sec + t.tv_nsec);
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t total = 0;
      std::memcpy(&total, CMSG_DATA(c), sizeof total);
      errors_.receive_overflows += total - kernel_overflows_;
      kernel_overflows_ = total;
    }
  }
  constexpr std::int64_t kOldest_ns = 100'000'000;  // older: the wall clock was set in between
  return own_now_ - Duration{std::abs(age_ns) < kOldest_ns ? age_ns : 0};
}

void SocketCan::note_error(const canfd_frame& raw) noexcept {
  ++errors_.error_frames;
  if (raw.can_id & CAN_ERR_BUSOFF) errors_.bus_off = true;
  if ((raw.can_id & CAN_ERR_CRTL) && (raw.data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)))
    errors_.error_passive = true;
  if ((raw.can_id & CAN_ERR_CRTL) && (raw.data[1] & CAN_ERR_CRTL_RX_OVERFLOW)) ++errors_.receive_overflows;
}

}  // namespace

std::unique_ptr<CanBus> open_socket_can(const std::string& interface, net::Clock& clock, CanHears hears,
                                        bool speaks_fd) {
  const std::string what = "CAN interface '" + interface + "': ";
  if (interface.empty() || interface.size() >= IFNAMSIZ) throw BusError(what + "no name of a network interface");
  const int fd = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd < 0 && errno == EAFNOSUPPORT) throw BusError(what + "this kernel has no CAN (AF_CAN is not supported)");
  if (fd < 0) throw BusError(what + reason());
  auto bus = std::make_unique<SocketCan>(fd, interface, clock);  // closes fd, whatever follows
  ifreq request{};
  std::copy(interface.begin(), interface.end(), request.ifr_name);
  if (::ioctl(fd, SIOCGIFINDEX, &request) != 0) throw BusError(what + reason());
  const int index = request.ifr_ifindex;
  if (::ioctl(fd, SIOCGIFFLAGS, &request) != 0) throw BusError(what + reason());
  if (!(request.ifr_flags & IFF_UP)) throw BusError(what + "it is down (ip link set " + interface + " up)");
  if (::ioctl(fd, SIOCGIFMTU, &request) != 0) throw BusError(what + reason());
  const bool knows_fd = request.ifr_mtu == static_cast<int>(CANFD_MTU);
  if (speaks_fd && !knows_fd)
    throw BusError(what + "a drive on it speaks CAN FD, the interface does not (ip link set " + interface + " mtu 72)");
  if (knows_fd && (speaks_fd || hears == CanHears::kEverything))
    set_option(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, int{1}, "CAN_RAW_FD_FRAMES");
  set_option(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}, "CAN_RAW_ERR_FILTER");
  set_option(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, int{1}, "CAN_RAW_RECV_OWN_MSGS");
  set_option(fd, SOL_SOCKET, SO_TIMESTAMPNS, int{1}, "SO_TIMESTAMPNS");
  set_option(fd, SOL_SOCKET, SO_RXQ_OVFL, int{1}, "SO_RXQ_OVFL");
  if (hears == CanHears::kController) set_filters(fd);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) throw BusError(what + reason());
  return bus;
}

}  // namespace armsight::arm
