#include "tools/replay/relay.hpp"

#include <array>
#include <asio/connect.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "protocol/config_error.hpp"
#include "protocol/framing.hpp"
#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"
#include "protocol/transport/clock.hpp"

namespace armsight::replay {
namespace {

using asio::ip::tcp;

constexpr Duration kFlushPeriod = std::chrono::seconds(1);
constexpr Duration kLastWords = std::chrono::seconds(1);  // for the side that was left

tcp::endpoint endpoint(const char* flag, const std::string& address) {
  const std::size_t colon = address.rfind(':');
  asio::error_code error;
  const std::string host = colon == std::string::npos ? "" : address.substr(0, colon);
  const auto ip = asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, error);
  char* end = nullptr;
  const long port = colon == std::string::npos ? -1 : std::strtol(address.c_str() + colon + 1, &end, 10);
  if (error || port < 0 || port > 65535 || end == address.c_str() + colon + 1 || *end != '\0')
    throw ConfigError(std::string(flag) + " " + address + ": must be ADDR:PORT");
  return {ip, static_cast<unsigned short>(port)};
}

}  // namespace

struct Relay::Impl {
  /// One direction of the relay.
  struct Pump {
    Pump(tcp::socket& source, tcp::socket& sink, bool towards_controller)
        : from(source), to(sink), to_controller(towards_controller),
          decoder(wire::FrameType::kLink, towards_controller ? wire::kMaxToController : wire::kMaxFromController) {}
    tcp::socket& from;
    tcp::socket& to;
    bool to_controller;
    wire::FrameDecoder decoder;
    std::array<char, 16 * 1024> bytes{};
  };

  explicit Impl(const RelayOptions& o);

  void open_file();
  void listen();
  void connect_arm();
  void on_host(const asio::error_code& error);
  void read(Pump& pump);
  void forward(Pump& pump, std::size_t size);
  void record(Pump& pump, std::size_t size);
  void write(bool to_controller, const std::string& payload);
  void on_left(Pump& pump);
  void end() { io.stop(); }

  RelayOptions options;
  tcp::endpoint arm_endpoint;
  asio::io_context io;
  asio::signal_set signals{io, SIGINT, SIGTERM};
  asio::steady_timer patience{io};
  bool is_one_gone = false;
  tcp::acceptor acceptor{io};
  tcp::socket host{io}, arm{io};
  Pump towards_arm{host, arm, true}, towards_host{arm, host, false};
  std::string peer, failure;
  std::unique_ptr<net::Clock> clock = net::make_monotonic_clock(std::chrono::milliseconds(1));
  std::ofstream out;
  std::unique_ptr<RecordingWriter> writer;
  ChannelId link = 0;
  Time last_flush{};
};

Relay::Impl::Impl(const RelayOptions& o) : options(o), arm_endpoint(endpoint("--arm", o.arm_address)) {
  listen();
  connect_arm();
  open_file();
}

void Relay::Impl::listen() {
  const tcp::endpoint own = endpoint("--listen", options.listen_address);
  const std::string flag = "--listen " + options.listen_address + ": ";
  if (!own.address().is_loopback())
    throw ConfigError(flag + "must be a loopback address: the link has no encryption yet");
  asio::error_code error;
  acceptor.open(own.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(own, error);
  if (!error) acceptor.listen(1, error);
  if (error) throw ConfigError(flag + error.message());
}

// Before any host can speak: in lockstep a message counts as lost when its sender's connection is not even in the
// controller's backlog by the time the sender says that it was sent.
void Relay::Impl::connect_arm() {
  asio::error_code error;
  arm.connect(arm_endpoint, error);
  if (error) throw ArmUnreachable("cannot reach " + options.arm_address + ": " + error.message());
  arm.set_option(tcp::no_delay(true), error);
}

void Relay::Impl::open_file() {
  out.open(options.file, std::ios::binary | std::ios::trunc);
  if (!out) throw ConfigError("--out " + options.file.string() + ": cannot be written");
  writer = std::make_unique<RecordingWriter>(out, RecordingOptions{"link_record"});
  const ChannelId info_channel = writer->add_channel("/info", "armsight.wire.RecordingInfo");
  link = writer->add_channel("/link", "armsight.wire.LinkRecord");
  wire::RecordingInfo info;
  info.set_program("link_record " ARMSIGHT_VERSION);
  info.set_time_ns(to_ns(clock->now()));
  writer->write(info_channel, clock->now(), info.SerializeAsString());
}

void Relay::Impl::on_host(const asio::error_code& error) {
  if (error) {
    failure = "no host could connect: " + error.message();
    return end();
  }
  asio::error_code problem;
  acceptor.close(problem);
  const tcp::endpoint remote = host.remote_endpoint(problem);
  peer = remote.address().to_string() + ":" + std::to_string(remote.port());
  host.set_option(tcp::no_delay(true), problem);
  std::printf("link_record: recording %s\n", peer.c_str());
  read(towards_arm);
  read(towards_host);
}

void Relay::Impl::read(Pump& pump) {
  pump.from.async_read_some(asio::buffer(pump.bytes), [this, &pump](const asio::error_code& error, std::size_t size) {
    if (error) return on_left(pump);
    record(pump, size);
    forward(pump, size);
  });
}

// Closing a socket with unread bytes resets it, and the last message the other way (a Bye) could be lost: so the side
// that was left is told, and read until it closes too.
void Relay::Impl::on_left(Pump& pump) {
  if (is_one_gone) return end();
  is_one_gone = true;
  asio::error_code ignored_if_gone;
  pump.to.shutdown(tcp::socket::shutdown_send, ignored_if_gone);
  patience.expires_after(kLastWords);
  patience.async_wait([this](const asio::error_code&) { end(); });
}

void Relay::Impl::forward(Pump& pump, std::size_t size) {
  asio::async_write(pump.to, asio::buffer(pump.bytes, size), [this, &pump](const asio::error_code&, std::size_t) {
    read(pump);  // a receiver that is gone shows when its own direction ends
  });
}

void Relay::Impl::record(Pump& pump, std::size_t size) {
  if (pump.decoder.error() != wire::FrameError::kNone) return;
  std::vector<std::string> payloads;
  const bool is_sound = pump.decoder.feed({pump.bytes.data(), size}, payloads);
  for (const std::string& payload : payloads) write(pump.to_controller, payload);
  if (!is_sound)
    std::fprintf(stderr, "link_record: %s: %s; forwarded on, recorded up to here\n",
                 pump.to_controller ? "host" : "controller", wire::to_text(pump.decoder.error()));
}

void Relay::Impl::write(bool to_controller, const std::string& payload) {
  wire::LinkRecord record;
  if (!record.mutable_envelope()->ParseFromString(payload)) {
    std::fprintf(stderr, "link_record: %s: a frame that holds no Envelope; forwarded, not recorded\n",
                 to_controller ? "host" : "controller");
    return;
  }
  const Time now = clock->now();
  record.set_to_controller(to_controller);
  record.set_peer(peer);
  record.set_time_ns(to_ns(now));
  writer->write(link, now, record.SerializeAsString());
  if (now - last_flush < kFlushPeriod) return;
  last_flush = now;
  writer->flush();
}

Relay::Relay(const RelayOptions& options) : impl_(std::make_unique<Impl>(options)) {}

Relay::~Relay() = default;

std::uint16_t Relay::port() const { return impl_->acceptor.local_endpoint().port(); }

std::uint64_t Relay::run() {
  impl_->signals.async_wait([this](const asio::error_code& error, int) {
    if (!error) impl_->end();
  });
  impl_->acceptor.async_accept(impl_->host, [this](const asio::error_code& error) { impl_->on_host(error); });
  impl_->io.run();
  impl_->writer->close();
  if (!impl_->failure.empty()) throw std::runtime_error(impl_->failure);
  if (!impl_->writer->is_good()) throw std::runtime_error("--out " + impl_->options.file.string() + ": writing failed");
  return impl_->writer->message_count() - 1;  // without /info
}

}  // namespace armsight::replay
