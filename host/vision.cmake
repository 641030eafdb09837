# What the host sees with: markers, poses, looks. imgcodecs and videoio bring 240 shared libraries, so that cameras and
# picture files stand apart in armsight_host_camera.
add_library(armsight_host_vision STATIC
  edge_refine.cpp
  intrinsics.cpp
  look.cpp
  marker.cpp
  marker_print.cpp
  overlay.cpp
  planar_pose.cpp)
target_include_directories(armsight_host_vision SYSTEM PUBLIC ${OpenCV_INCLUDE_DIRS})
target_link_libraries(armsight_host_vision
  PUBLIC armsight_core armsight_protocol opencv_core
  PRIVATE opencv_imgproc opencv_calib3d opencv_aruco yaml-cpp armsight_warnings)

add_library(armsight_host_camera STATIC
  camera.cpp
  camera_files.cpp
  camera_sim.cpp
  camera_v4l2.cpp
  image_file.cpp)
target_link_libraries(armsight_host_camera
  PUBLIC armsight_host_vision armsight_transport
  PRIVATE armsight_schemas opencv_imgcodecs opencv_videoio armsight_warnings)
