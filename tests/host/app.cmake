# Tests of the host's flows: planning, clocks, the grasp table, what a bad command line meets.
add_armsight_test(host_app_tests LABEL unit
  SOURCES app_arm_link_test.cpp app_clock_alignment_test.cpp app_grasp_test.cpp app_calibrate_files_test.cpp
          app_commission_test.cpp app_planned_motion_test.cpp app_pose_planner_test.cpp app_route_test.cpp
          app_run_test.cpp app_session_files_test.cpp app_stop_test.cpp
  LIBS armsight_host_app armsight_test_looks)
target_compile_definitions(host_app_tests PRIVATE ARMSIGHT_GRASPS_YAML="${CMAKE_SOURCE_DIR}/host/config/grasps.yaml"
  ARMSIGHT_ROBOT_YAML="${CMAKE_SOURCE_DIR}/arm_controller/config/ego_right_arm.yaml")
