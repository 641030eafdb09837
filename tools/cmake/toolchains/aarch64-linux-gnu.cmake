# The controller for ARM computers of 64 bits, built on another Debian machine with the libraries of Debian's arm64
# (./tools/setup arm64). What runs during the build, protoc, is this machine's; what was built runs in qemu.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
list(APPEND CMAKE_PREFIX_PATH ${CMAKE_CURRENT_LIST_DIR}/../../../build/unpacked/arm64/usr)
foreach(other x86_64-linux-gnu i386-linux-gnu)  # never a library of the building machine, nor its packages' word
  list(APPEND CMAKE_IGNORE_PATH /usr/lib/${other} /usr/lib/${other}/cmake)
endforeach()
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
find_program(ARMSIGHT_EMULATOR NAMES qemu-aarch64 qemu-aarch64-static)
if(ARMSIGHT_EMULATOR)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${ARMSIGHT_EMULATOR} -L /usr/aarch64-linux-gnu)
endif()
