// A small recording with known numbers, for the tests here and for the independent reader.
#pragma once

#include <sstream>
#include <string>

#include "protocol/recording.hpp"
#include "protocol/recording.pb.h"

namespace armsight {

inline constexpr int kSampleTicks = 500;
inline constexpr std::int64_t kSampleStart_ns = 1'000'000'000, kSamplePeriod_ns = 4'000'000;

/// Tick i: q_reading_rad = [0.001 i, -0.5], mode HOLD; every 100th tick a Stop on /link with the tick's number as
/// sequence.
inline void write_sample(RecordingWriter& writer) {
  const ChannelId tick = writer.add_channel("/tick", "armsight.wire.TickRecord");
  const ChannelId link = writer.add_channel("/link", "armsight.wire.LinkRecord");
  for (int i = 0; i < kSampleTicks; ++i) {
    const Time time = time_from_ns(kSampleStart_ns + i * kSamplePeriod_ns);
    wire::TickRecord record;
    record.set_arm_time_ns(to_ns(time));
    record.set_cycle(static_cast<std::uint64_t>(i));
    record.set_mode(wire::MODE_HOLD);
    record.add_q_reading_rad(0.001 * i);
    record.add_q_reading_rad(-0.5);
    writer.write(tick, time, record.SerializeAsString());
    if (i % 100 != 0) continue;
    wire::LinkRecord message;
    message.set_to_controller(true);
    message.set_peer("127.0.0.1:40312");
    message.mutable_envelope()->set_sequence(static_cast<std::uint64_t>(i));
    message.mutable_envelope()->mutable_stop()->set_reason("operator");
    writer.write(link, time, message.SerializeAsString());
  }
}

inline std::string sample_recording() {
  std::ostringstream out;
  RecordingWriter writer(out, {"armsight tests", 4096});
  write_sample(writer);
  writer.close();
  return out.str();
}

}  // namespace armsight
