// What a black box holds for a cycle, read with suspicion: the file may come from anywhere, and past the build id nobody
// vouches for its bytes. All throw NotReplayable.
#pragma once

#include "arm_controller/messages.hpp"
#include "protocol/recording.pb.h"

namespace armsight::arm {

/// A frame that no CAN bus carries (beyond 8 bytes, an identifier beyond 11 bits) or an unknown send_result.
void check_frame(const wire::CanRecord& frame);
/// The messages of a cycle as the tick was given them, for an arm of so many joints. Refused: more looks than a tick
/// takes, unknown enumerators, vectors and matrices of another size.
TickInbox inbox_of(const wire::CycleInput& in, int joint_count);

}  // namespace armsight::arm
