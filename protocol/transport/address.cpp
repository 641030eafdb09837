#include "protocol/transport/address.hpp"

#include <asio/io_context.hpp>
#include <poll.h>
#include <sys/un.h>

#include <charconv>
#include <filesystem>
#include <stdexcept>

#include "protocol/config_error.hpp"
#include "protocol/transport/framed_stream.hpp"
#include "protocol/transport/socket_stream.hpp"

namespace armsight::net {

asio::ip::tcp::endpoint resolve_tcp(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0)
    throw ConfigError("address '" + address + "': must be HOST:PORT");
  const std::string host = address.substr(0, colon);
  const std::string port = address.substr(colon + 1);
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc{} || end != port.data() + port.size())
    throw ConfigError("address '" + address + "': the port must be a number from 0 to 65535");
  asio::error_code failed;
  asio::ip::tcp::resolver resolver(socket_context());
  const auto found = resolver.resolve(asio::ip::tcp::v4(), host, port, failed);
  if (failed || found.empty()) throw std::runtime_error("address '" + address + "': " + failed.message());
  return found.begin()->endpoint();
}

std::string loopback_address(const std::string& address) {
  const asio::ip::tcp::endpoint endpoint = resolve_tcp(address);
  if (endpoint.address().is_loopback()) return endpoint.address().to_string() + ":" + std::to_string(endpoint.port());
  throw ConfigError("means " + endpoint.address().to_string());
}

asio::local::stream_protocol::endpoint unix_endpoint(const std::string& path) {
  if (path.empty() || path.size() >= sizeof(sockaddr_un::sun_path))
    throw std::runtime_error("socket path '" + path + "': must have 1 to 107 characters");
  return asio::local::stream_protocol::endpoint(path);
}

void remove_stale_socket(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_socket(path, ignored)) return;
  asio::local::stream_protocol::socket probe(socket_context());
  asio::error_code error;
  probe.connect(unix_endpoint(path), error);
  if (error == asio::error::connection_refused) std::filesystem::remove(path, ignored);
}

bool wait_writable(int descriptor, Duration timeout) {
  pollfd entry{descriptor, POLLOUT, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
  return ::poll(&entry, 1, static_cast<int>(ms)) == 1;
}

}  // namespace armsight::net
