// FramedStream over one connected socket, TCP or AF_UNIX. Internal to the transport.
#pragma once

#include <asio/generic/stream_protocol.hpp>
#include <asio/io_context.hpp>

#include <deque>
#include <optional>

#include "protocol/transport/framed_stream.hpp"

namespace armsight::net {

/// Asio's sockets want a context; nothing is ever run on it.
asio::io_context& socket_context();

class SocketStream : public FramedStream, public Flow {
 public:
  using Socket = asio::generic::stream_protocol::socket;

  /// clock may be null: then nothing is counted and arrivals are zero.
  SocketStream(Socket socket, std::string peer_name, const StreamOptions& options, Clock* clock);
  ~SocketStream() override;

  bool send(std::string_view payload) override;
  std::vector<Received> receive() override;
  bool is_open() const override { return is_open_; }
  std::string close_reason() const override { return close_reason_; }
  void close(const std::string& reason) override;
  int descriptor() const override { return descriptor_; }
  void set_channel(ChannelKey channel) override { channel_ = channel; }
  const std::string& peer_name() const override { return peer_name_; }

  int flow_descriptor() const override { return descriptor_; }
  bool has_unsent() const override { return is_open_ && sent_bytes_ < unsent_.size(); }
  void send_more() override;

  // For those who decide themselves which messages act now (StreamServer, the clock).
  /// Reads what the socket holds, never blocks.
  void read_available();
  std::size_t queued() const { return incoming_.size(); }
  const std::string& front() const { return incoming_.front(); }
  std::string pop();
  bool has_channel() const { return channel_.has_value(); }

 private:
  std::vector<Received> receive_due();

  Socket socket_;
  int descriptor_;
  std::string peer_name_;
  StreamOptions options_;
  Clock* clock_;
  std::optional<ChannelKey> channel_;
  wire::FrameDecoder decoder_;
  std::deque<std::string> incoming_;
  std::size_t incoming_bytes_ = 0;
  std::string unsent_;
  std::size_t sent_bytes_ = 0;
  bool is_open_ = true;
  std::string close_reason_;
};

}  // namespace armsight::net
