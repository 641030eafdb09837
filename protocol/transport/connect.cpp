// Connecting and listening: TCP and AF_UNIX sockets become FramedStreams.
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <sys/socket.h>

#include <stdexcept>

#include "protocol/transport/address.hpp"
#include "protocol/transport/socket_stream.hpp"

namespace armsight::net {

namespace {

std::string to_text(const asio::ip::tcp::endpoint& endpoint) {
  return endpoint.address().to_string() + ":" + std::to_string(endpoint.port());
}

/// A connect(2) that gives up after the timeout.
template <class Protocol>
typename Protocol::socket connect_within(const typename Protocol::endpoint& endpoint, const std::string& name,
                                         Duration timeout) {
  typename Protocol::socket socket(socket_context());
  asio::error_code error;
  socket.open(endpoint.protocol());
  socket.non_blocking(true);
  socket.connect(endpoint, error);
  if (error == asio::error::in_progress || error == asio::error::would_block || error == asio::error::try_again) {
    if (!wait_writable(socket.native_handle(), timeout)) throw std::runtime_error("cannot reach " + name + ": no answer");
    int code = 0;
    socklen_t size = sizeof code;
    ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_ERROR, &code, &size);
    error = asio::error_code(code, asio::system_category());
  }
  if (error) throw std::runtime_error("cannot reach " + name + ": " + error.message());
  return socket;
}

}  // namespace

std::unique_ptr<FramedStream> connect_tcp(const std::string& address, const StreamOptions& options, Clock& clock,
                                          Duration timeout) {
  auto socket = connect_within<asio::ip::tcp>(resolve_tcp(address), address, timeout);
  socket.set_option(asio::ip::tcp::no_delay(true));
  return std::make_unique<SocketStream>(std::move(socket), address, options, &clock);
}

std::unique_ptr<FramedStream> connect_unix(const std::string& path, const StreamOptions& options, Clock& clock) {
  auto socket = connect_within<asio::local::stream_protocol>(unix_endpoint(path), path, std::chrono::seconds(5));
  return std::make_unique<SocketStream>(std::move(socket), path, options, &clock);
}

namespace {

template <class Protocol>
class SocketListener : public Listener {
 public:
  SocketListener(const typename Protocol::endpoint& endpoint, const std::string& name) : acceptor_(socket_context()) {
    try {
      acceptor_.open(endpoint.protocol());
      if constexpr (is_tcp) acceptor_.set_option(asio::socket_base::reuse_address(true));
      acceptor_.bind(endpoint);
      acceptor_.listen();
      acceptor_.non_blocking(true);
    } catch (const std::system_error& error) {
      throw std::runtime_error("cannot listen on " + name + ": " + error.code().message());
    }
  }

  std::unique_ptr<FramedStream> accept(const StreamOptions& options, Clock& clock) override {
    asio::error_code error;
    typename Protocol::endpoint peer;
    typename Protocol::socket socket(socket_context());
    acceptor_.accept(socket, peer, error);
    if (error) return nullptr;  // nobody there, or gone again before we looked
    std::string name = "local";
    if constexpr (is_tcp) {
      socket.set_option(asio::ip::tcp::no_delay(true), error);
      name = to_text(peer);
    }
    return std::make_unique<SocketStream>(std::move(socket), std::move(name), options, &clock);
  }

  std::uint16_t port() const override {
    if constexpr (is_tcp) return acceptor_.local_endpoint().port();
    return 0;
  }
  int descriptor() const override { return const_cast<typename Protocol::acceptor&>(acceptor_).native_handle(); }

 private:
  static constexpr bool is_tcp = std::is_same_v<Protocol, asio::ip::tcp>;
  typename Protocol::acceptor acceptor_;
};

}  // namespace

std::unique_ptr<Listener> listen_tcp(const std::string& address) {
  return std::make_unique<SocketListener<asio::ip::tcp>>(resolve_tcp(address), address);
}

std::unique_ptr<Listener> listen_unix(const std::string& path) {
  const auto endpoint = unix_endpoint(path);
  remove_stale_socket(path);
  return std::make_unique<SocketListener<asio::local::stream_protocol>>(endpoint, path);
}

}  // namespace armsight::net
