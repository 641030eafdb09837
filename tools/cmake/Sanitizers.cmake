# ARMSIGHT_SANITIZE=address (with undefined behaviour) or thread; empty: none.

set(ARMSIGHT_SANITIZE "" CACHE STRING "address | thread | empty")
if(ARMSIGHT_SANITIZE STREQUAL "address")
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -O1)
  add_link_options(-fsanitize=address,undefined)
elseif(ARMSIGHT_SANITIZE STREQUAL "thread")
  add_compile_options(-fsanitize=thread -O1)
  add_link_options(-fsanitize=thread)
elseif(NOT ARMSIGHT_SANITIZE STREQUAL "")
  message(FATAL_ERROR "armsight: ARMSIGHT_SANITIZE=${ARMSIGHT_SANITIZE}: must be address, thread or empty")
endif()
