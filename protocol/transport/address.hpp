// "HOST:PORT" and socket paths → endpoints, with errors that name the address. Internal to the transport.
#pragma once

#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>

#include <string>

#include "shared/time.hpp"

namespace armsight::net {

asio::ip::tcp::endpoint resolve_tcp(const std::string& address);
asio::local::stream_protocol::endpoint unix_endpoint(const std::string& path);
/// A socket file that nobody listens on any more is in the way of bind(2); anything else is left alone.
void remove_stale_socket(const std::string& path);
bool wait_writable(int descriptor, Duration timeout);

}  // namespace armsight::net
