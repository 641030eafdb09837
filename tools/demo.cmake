# The demo and its report; included by tools/CMakeLists.txt.
add_subdirectory(report)

add_executable(demo_run demo_run.cpp)
target_link_libraries(demo_run PRIVATE armsight_report armsight_command_line armsight_warnings)
