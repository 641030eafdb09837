# Recording the link and playing recordings again; included by tools/CMakeLists.txt.
add_library(armsight_replay STATIC
  replay/envelope_fields.cpp
  replay/filter_replay.cpp
  replay/link_file.cpp
  replay/link_player.cpp)
target_link_libraries(armsight_replay PUBLIC armsight_transport armsight_protocol PRIVATE armsight_warnings)

add_executable(link_replay link_replay.cpp)
target_link_libraries(link_replay PRIVATE armsight_replay armsight_report armsight_command_line armsight_warnings)

add_executable(link_record link_record.cpp replay/relay.cpp)
target_link_libraries(link_record PRIVATE armsight_transport armsight_asio armsight_command_line armsight_warnings)
target_compile_definitions(link_record PRIVATE ARMSIGHT_VERSION="${PROJECT_VERSION}")

add_executable(ekf_replay ekf_replay.cpp)
target_link_libraries(ekf_replay PRIVATE armsight_replay armsight_command_line armsight_warnings)
