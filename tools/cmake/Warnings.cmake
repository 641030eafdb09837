# Link armsight_warnings PRIVATE to every target of ours; generated code goes without.

option(ARMSIGHT_WERROR "Treat warnings as errors" OFF)
add_library(armsight_warnings INTERFACE)
target_compile_options(armsight_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wdouble-promotion
  $<$<BOOL:${ARMSIGHT_WERROR}>:-Werror -Wno-error=array-bounds -Wno-error=maybe-uninitialized -Wno-error=stringop-overflow>)
