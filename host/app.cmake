# The flows of the host and its program. The command line is main.cpp's alone.
add_library(armsight_host_app STATIC
  adapt.cpp
  arm_link.cpp
  calibrate.cpp
  calibrate_files.cpp
  clock_alignment.cpp
  commission.cpp
  dry_run.cpp
  first_sight.cpp
  grasp.cpp
  grasp_plan.cpp
  grasp_table.cpp
  hand_looks.cpp
  host_io.cpp
  joint_fit.cpp
  json_out.cpp
  look_planning.cpp
  motion.cpp
  operator.cpp
  planned_motion.cpp
  pose_planner.cpp
  power_verbs.cpp
  robot_file_edit.cpp
  route.cpp
  run_verb.cpp
  running_guess.cpp
  session_files.cpp
  small_verbs.cpp
  status.cpp
  text.cpp
  visibility.cpp)
target_link_libraries(armsight_host_app
  PUBLIC armsight_core armsight_protocol armsight_schemas armsight_transport armsight_host_vision armsight_host_camera
         armsight_host_learn
  PRIVATE nlohmann_json::nlohmann_json armsight_warnings)
target_compile_definitions(armsight_host_app PRIVATE ARMSIGHT_VERSION="${PROJECT_VERSION}")

add_executable(host main.cpp)
target_link_libraries(host PRIVATE armsight_host_app CLI11::CLI11 armsight_warnings)
