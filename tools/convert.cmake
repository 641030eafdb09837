# Other people's calibration sets as data-set folders.
add_library(armsight_convert STATIC
  convert/convert.cpp
  convert/convert_camodocal.cpp
  convert/convert_ethz.cpp
  convert/convert_rct.cpp
  convert/convert_talos.cpp
  convert/convert_ur10e.cpp
  convert/text_files.cpp)
target_link_libraries(armsight_convert PUBLIC armsight_protocol PRIVATE armsight_warnings)

add_executable(convert_dataset convert_dataset.cpp)
target_link_libraries(convert_dataset PRIVATE armsight_convert armsight_command_line armsight_warnings)
