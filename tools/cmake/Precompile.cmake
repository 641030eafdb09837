# Precompiled headers, for the build from nothing: Eigen, the standard library and GoogleTest cost each file 2 to 4 s of
# reading. The preset `release` asks for them; `dev` does without, so that a missing #include shows there.
option(ARMSIGHT_PRECOMPILE "Read the headers that nearly every file includes only once" OFF)

# What the rooms share; the tests add GoogleTest (tests/CMakeLists.txt).
set(ARMSIGHT_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <cstdio> <deque> <fstream> <functional> <map> <memory> <optional> <random> <sstream>
  <stdexcept> <string> <thread> <vector> <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU>)

# armsight_precompile(OWNER HEADER...): OWNER compiles the headers for itself and for others built with the same flags.
function(armsight_precompile owner)
  if(ARMSIGHT_PRECOMPILE)
    target_precompile_headers(${owner} PRIVATE ${ARGN})
    target_compile_options(${owner} PRIVATE -fpch-preprocess)  # lets ccache see through them
  endif()
endfunction()

# armsight_reuse(TARGET OWNER): TARGET, built with the flags of OWNER, takes OWNER's.
function(armsight_reuse target owner)
  if(ARMSIGHT_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${owner})
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  endif()
endfunction()

# Every program and library in the folders below `directory` takes the headers of armsight_core, but for the generated
# schemas (no Eigen) and the renderer (its own flags).
function(armsight_reuse_below directory)
  get_property(rooms DIRECTORY ${directory} PROPERTY SUBDIRECTORIES)
  foreach(room ${rooms})
    get_property(targets DIRECTORY ${room} PROPERTY BUILDSYSTEM_TARGETS)
    list(REMOVE_ITEM targets armsight_core armsight_schemas armsight_sim_render)
    foreach(target ${targets})
      get_target_property(type ${target} TYPE)
      if(type MATCHES "STATIC_LIBRARY|EXECUTABLE")
        armsight_reuse(${target} armsight_core)
      endif()
    endforeach()
    armsight_reuse_below(${room})
  endforeach()
endfunction()
