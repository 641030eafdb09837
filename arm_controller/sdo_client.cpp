#include "arm_controller/sdo_client.hpp"

namespace armsight::arm {

void SdoClient::start(const SdoWrite& request, bool is_write) noexcept {
  request_ = request;
  is_write_ = is_write;
  is_sent_ = false;
  attempts_ = 0;
  result_ = SdoResult::kPending;
}

void SdoClient::receive(const CanFrame& frame, std::uint8_t node) noexcept {
  if (result_ != SdoResult::kPending || !is_sent_) return;
  if (const auto abort = decode_sdo_answer_abort(frame, node); abort && abort->object == request_.object) {
    value_ = abort->code;
    result_ = SdoResult::kAborted;
  } else if (const auto read = decode_sdo_read_answer(frame, node);
             !is_write_ && read && read->object == request_.object) {
    value_ = read->value;
    result_ = SdoResult::kDone;
  } else if (const auto write = decode_sdo_write_answer(frame, node);
             is_write_ && write && write->object == request_.object) {
    result_ = SdoResult::kDone;
  }
}

std::optional<CanFrame> SdoClient::request_to_send(std::uint8_t node, Time now) noexcept {
  if (result_ != SdoResult::kPending) return std::nullopt;
  if (is_sent_ && now - sent_ < kTimeout) return std::nullopt;
  if (attempts_ == kAttempts) {
    result_ = SdoResult::kTimedOut;
    return std::nullopt;
  }
  ++attempts_;
  is_sent_ = true;
  sent_ = now;
  return is_write_ ? encode(request_, node) : encode(SdoRead{request_.object}, node);
}

}  // namespace armsight::arm
