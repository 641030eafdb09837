# Tests of the simulated camera.
add_armsight_test(sim_render_tests LABEL unit TIMEOUT 300
  SOURCES camera_server_test.cpp renderer_test.cpp
  LIBS armsight_sim_render armsight_host_camera armsight_schemas)
target_compile_definitions(sim_render_tests PRIVATE ARMSIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
