// Envelopes as flat lists of named values, and where two of them first differ. The lite runtime of protobuf has no
// reflection, so the fields stand here by name; a message the controller never sends has none.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/arm_link.pb.h"

namespace armsight::replay {

struct Field {
  std::string name;                        ///< "goal_status.q_reading_rad[2]"
  std::variant<std::int64_t, double, std::string> value;
};

/// "goal_status"; "message 99" for what this program does not know.
std::string body_name(const wire::Envelope& envelope);
/// What must come again in a replay: all but the session and the wall-clock figures of the statistics.
std::vector<Field> repeatable_fields(const wire::Envelope& envelope);

struct FieldDifference {
  std::string field, recorded, replayed;
};
inline constexpr double kSameValue = 1e-9;  ///< absolute, in the fields' units
/// The first field that differs: floating point by more than kSameValue, everything else at all.
std::optional<FieldDifference> first_difference(const wire::Envelope& recorded, const wire::Envelope& replayed);

}  // namespace armsight::replay
