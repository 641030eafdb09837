// Does everything that a serialized message announces lie inside it? Protobuf checks a nested message's length only when
// it has read to the end, and meanwhile reserves for a text or an unknown field whatever that announces: up to 50 MB for
// a frame of a hundred bytes. Asked before the parser is.
#pragma once

#include <string_view>

namespace armsight::wire {

/// Two levels: the fields of `payload`, and those of its nested messages; deeper ones of the link hold plain numbers.
/// All length-delimited fields of the outer message must be messages. Groups, which no schema of ours has, are refused.
bool lengths_fit(std::string_view payload) noexcept;

}  // namespace armsight::wire
