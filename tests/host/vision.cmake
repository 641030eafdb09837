# Tests of what the host sees with: files, poses, prints, rendered pictures, photographs.
add_armsight_test(host_vision_tests LABEL unit TIMEOUT 300
  SOURCES vision_files_test.cpp vision_photos_test.cpp vision_pose_test.cpp vision_print_test.cpp vision_renders_test.cpp
  LIBS armsight_host_camera armsight_sim_render opencv_imgcodecs opencv_imgproc opencv_videoio)
target_compile_definitions(host_vision_tests PRIVATE ARMSIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
