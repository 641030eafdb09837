#include "protocol/transport/socket_stream.hpp"

#include <asio/buffer.hpp>

#include <array>
#include <stdexcept>

#include "protocol/transport/wait.hpp"

namespace armsight::net {

asio::io_context& socket_context() {
  static asio::io_context context;
  return context;
}

SocketStream::SocketStream(Socket socket, std::string peer_name, const StreamOptions& options, Clock* clock)
    : socket_(std::move(socket)),
      descriptor_(socket_.native_handle()),
      peer_name_(std::move(peer_name)),
      options_(options),
      clock_(clock),
      decoder_(options.type, options.max_incoming) {
  socket_.non_blocking(true);
  if (clock_ != nullptr) clock_->add_flow(this);
}

SocketStream::~SocketStream() {
  if (clock_ != nullptr) clock_->remove_flow(this);
}

bool SocketStream::send(std::string_view payload) {
  if (!is_open_) return false;
  if (payload.size() > options_.max_outgoing)
    throw std::length_error("message of " + std::to_string(payload.size()) + " bytes to " + peer_name_ +
                            ": at most " + std::to_string(options_.max_outgoing) + " may be sent");
  unsent_ += wire::encode_frame(options_.type, payload);
  send_more();
  if (is_open_ && unsent_.size() - sent_bytes_ > options_.max_queued_bytes) close("peer reads too slowly");
  if (is_open_ && channel_ && clock_ != nullptr) clock_->count_sent(*channel_);
  return is_open_;
}

void SocketStream::send_more() {
  while (has_unsent()) {
    asio::error_code error;
    const std::size_t n = socket_.send(asio::buffer(unsent_.data() + sent_bytes_, unsent_.size() - sent_bytes_), 0, error);
    if (error == asio::error::would_block || error == asio::error::try_again) return;
    if (error) return close(error.message());
    sent_bytes_ += n;
  }
  unsent_.clear();
  sent_bytes_ = 0;
}

void SocketStream::read_available() {
  std::array<char, 64 * 1024> bytes;
  std::vector<std::string> payloads;
  while (is_open_ && incoming_bytes_ <= options_.max_queued_bytes) {
    asio::error_code error;
    const std::size_t n = socket_.receive(asio::buffer(bytes), 0, error);
    if (error == asio::error::would_block || error == asio::error::try_again) return;
    if (error == asio::error::eof) return close("closed by the peer");
    if (error) return close(error.message());
    payloads.clear();
    const bool is_sound = decoder_.feed(std::span<const char>(bytes.data(), n), payloads);
    for (std::string& payload : payloads) {
      incoming_bytes_ += payload.size() + wire::kFrameHeaderSize;  // or empty ones would never fill the queue
      incoming_.push_back(std::move(payload));
    }
    if (!is_sound) return close(std::string("bad frame: ") + wire::to_text(decoder_.error()));
  }
}

std::string SocketStream::pop() {
  std::string payload = std::move(incoming_.front());
  incoming_.pop_front();
  incoming_bytes_ -= payload.size() + wire::kFrameHeaderSize;
  return payload;
}

std::vector<Received> SocketStream::receive() {
  send_more();
  if (clock_ != nullptr && clock_->is_lockstep() && channel_) return receive_due();
  read_available();
  const Time arrival = clock_ != nullptr ? clock_->now() : Time{};
  std::vector<Received> messages;
  while (!incoming_.empty()) messages.push_back({pop(), arrival});
  return messages;
}

std::vector<Received> SocketStream::receive_due() {
  const std::span<const Time> due = clock_->due(*channel_);
  const std::vector<Time> arrivals(due.begin(), due.end());
  read_available();
  const int descriptors[] = {descriptor_};
  while (is_open_ && incoming_.size() < arrivals.size()) {
    wait_and_flow(descriptors, Duration{-1}, clock_);
    read_available();
  }
  std::vector<Received> messages;
  for (const Time arrival : arrivals) {
    clock_->count_received(*channel_);
    if (!incoming_.empty()) messages.push_back({pop(), arrival});
  }
  return messages;
}

void SocketStream::close(const std::string& reason) {
  if (!is_open_) return;
  is_open_ = false;
  close_reason_ = reason;
  asio::error_code ignored;  // the peer may be gone already: closing is all that is wanted
  socket_.close(ignored);
  descriptor_ = -1;  // the number may be another's soon; poll(2) skips -1
}

}  // namespace armsight::net
