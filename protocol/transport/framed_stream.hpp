// Framed messages over TCP or AF_UNIX streams: non-blocking, bounded, TCP_NODELAY. Both programs and the simulator use
// this one; sockets live in protocol/transport only, the rest of protocol/ is pure.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/framing.hpp"
#include "protocol/transport/clock.hpp"

namespace armsight::net {

struct Received {
  std::string payload;
  Time arrival;  ///< own clock: in lockstep as granted, at real pace when it was read
};

class FramedStream {
 public:
  virtual ~FramedStream() = default;

  /// Sends one message and counts it on the channel. False: the stream is closed or its peer reads too slowly (then
  /// the stream is closed).
  virtual bool send(std::string_view payload) = 0;
  /// Messages that act now. Real pace: what has arrived, never blocks. Lockstep: blocks until the due ones of the
  /// channel are here and returns exactly those; later ones stay queued for their cycle.
  virtual std::vector<Received> receive() = 0;
  virtual bool is_open() const = 0;
  virtual std::string close_reason() const = 0;
  virtual void close(const std::string& reason) = 0;
  /// For poll(2).
  virtual int descriptor() const = 0;
  /// Which channel of the clock's account this stream is; before that, messages are not counted.
  virtual void set_channel(ChannelKey channel) = 0;
  virtual const std::string& peer_name() const = 0;  ///< "127.0.0.1:40312"
};

struct StreamOptions {
  wire::FrameType type = wire::FrameType::kLink;
  std::size_t max_incoming = wire::kMaxFromController;
  std::size_t max_outgoing = wire::kMaxToController;
  std::size_t max_queued_bytes = 32 * 1024 * 1024;  ///< each way: unread beyond it waits in the socket, unsent closes
  std::size_t max_messages_at_once = SIZE_MAX;      ///< of a peer of a StreamServer, at real pace; the rest waits
};

/// "HOST:PORT" → stream, within timeout; throws std::runtime_error "cannot reach HOST:PORT: reason".
std::unique_ptr<FramedStream> connect_tcp(const std::string& address, const StreamOptions& options, Clock& clock,
                                          Duration timeout);
std::unique_ptr<FramedStream> connect_unix(const std::string& path, const StreamOptions& options, Clock& clock);

/// A listening socket. The server side of a stream learns its channel from the peer's first message.
class Listener {
 public:
  virtual ~Listener() = default;
  /// Non-blocking.
  virtual std::unique_ptr<FramedStream> accept(const StreamOptions& options, Clock& clock) = 0;
  virtual std::uint16_t port() const = 0;
  virtual int descriptor() const = 0;
};
/// "HOST:PORT" as "127.0.0.1:PORT"; throws ConfigError or std::runtime_error where it does not resolve to loopback.
std::string loopback_address(const std::string& address);
std::unique_ptr<Listener> listen_tcp(const std::string& address);  ///< "ADDR:PORT", port 0: the system chooses
std::unique_ptr<Listener> listen_unix(const std::string& path);

/// Many peers at one listener, in lockstep exactly the due messages of each, also of peers it has not met: a new stream's
/// first message tells (through `introduce`) which participant it is. Order: by participant id, then by arrival.
class StreamServer {
 public:
  /// First payload of a new stream → the peer's sim participant id (0 without a simulated clock).
  using Introduce = std::function<std::uint32_t(std::string_view first_payload)>;
  struct Event {
    FramedStream* stream = nullptr;      ///< stays valid until the event that says it closed was handed out
    bool is_closed = false;              ///< the stream is gone (close_reason()); no payload
    Received message;
  };

  StreamServer(const std::string& address, ChannelKind kind, const StreamOptions& options, Clock& clock,
               Introduce introduce, std::size_t max_streams = 8);
  ~StreamServer();
  std::vector<Event> receive();
  std::span<FramedStream* const> streams() const;
  std::vector<int> descriptors() const;   ///< listener and streams, for wait_readable
  std::uint16_t port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Waits until one of the descriptors is readable or the timeout is over.
void wait_readable(std::span<const int> descriptors, Duration timeout);

}  // namespace armsight::net
