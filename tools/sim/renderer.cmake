# What the simulated camera sees. Pictures only: no sockets, no picture files.
add_library(armsight_sim_render STATIC
  ${CMAKE_CURRENT_LIST_DIR}/optics.cpp
  ${CMAKE_CURRENT_LIST_DIR}/printed_marker.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ray_caster.cpp
  ${CMAKE_CURRENT_LIST_DIR}/renderer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shading.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shapes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/solids.cpp)
target_link_libraries(armsight_sim_render
  PUBLIC armsight_host_vision
  PRIVATE opencv_imgproc armsight_warnings)
