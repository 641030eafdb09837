# What the simulated camera sees, and its stream. No picture files: imgcodecs stays out.
add_library(armsight_sim_render STATIC
  ${CMAKE_CURRENT_LIST_DIR}/camera_server.cpp
  ${CMAKE_CURRENT_LIST_DIR}/optics.cpp
  ${CMAKE_CURRENT_LIST_DIR}/printed_marker.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ray_caster.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ray_caster_placement.cpp
  ${CMAKE_CURRENT_LIST_DIR}/renderer.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scene.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shading.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shapes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/solids.cpp)
target_link_libraries(armsight_sim_render
  PUBLIC armsight_host_vision armsight_transport
  PRIVATE armsight_schemas opencv_imgproc armsight_warnings)
# A frame costs a third less this way; nothing here looks at errno or at floating-point exceptions.
target_compile_options(armsight_sim_render PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O3 -fno-math-errno -fno-trapping-math>)
# Pure arithmetic of one thread, a picture's whole time: under the thread sanitizer it would take seconds a frame, and the
# programs whose threads are to be watched would only wait for it.
if(ARMSIGHT_SANITIZE STREQUAL "thread")
  foreach(part optics printed_marker ray_caster ray_caster_placement shading shapes solids)
    set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/${part}.cpp PROPERTIES
      COMPILE_OPTIONS -fno-sanitize=thread SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
  endforeach()
endif()
