// The schemas that recordings carry inside; recording_schemas.cpp is generated from the .proto files at build time.
#pragma once

#include <span>
#include <string_view>

namespace armsight {

/// Serialized google.protobuf.FileDescriptorSet of recording.proto and camera_stream.proto with what they import.
std::string_view recording_descriptor_set();
/// Full names of the messages in it, e.g. "armsight.wire.TickRecord".
std::span<const std::string_view> recording_message_types();

}  // namespace armsight
