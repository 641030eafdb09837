// Bytes from a hostile peer: framing, then Envelope, then the numbers in it.
#include <cstdlib>

#include "fuzz.hpp"
#include "protocol/convert.hpp"
#include "protocol/framing.hpp"

using namespace armsight;

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void convert(const wire::Envelope& envelope) {
  Pose T;
  JointVector q;
  StateMatrix P;
  if (!from_wire(envelope.pose_goal().hand_goal(), "pose", T)) require(is_finite(T) && is_rotation(T.R, 1e-9));
  if (!from_wire(envelope.joint_goal().q_real_rad(), "q", 5, q)) require(q.size() == 5 && q.allFinite());
  if (!from_wire(envelope.hand_pose().covariance(), "P", 6, P)) require(P.isApprox(P.transpose()) && P.allFinite());
  if (!from_wire(envelope.model_proposal().covariance(), "P", 11, P)) require(P.rows() == 11 && P.allFinite());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  wire::FrameDecoder decoder(wire::FrameType::kLink, wire::kMaxToController);
  std::vector<std::string> payloads;
  const std::span bytes(reinterpret_cast<const char*>(data), size);
  decoder.feed(bytes.first(size / 2), payloads);
  decoder.feed(bytes.subspan(size / 2), payloads);
  for (const std::string& payload : payloads) {
    require(payload.size() <= wire::kMaxToController);
    wire::Envelope envelope;
    if (envelope.ParseFromString(payload)) convert(envelope);
  }
  return 0;
}
