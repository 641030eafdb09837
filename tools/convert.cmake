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

# Learn on these sets, beside their peers' figures; a library, so that tests share it with prove_run.
add_library(armsight_proof STATIC proof/proof_sets.cpp proof/proof_text.cpp)
target_link_libraries(armsight_proof
  PUBLIC armsight_core PRIVATE armsight_host_learn armsight_convert nlohmann_json::nlohmann_json armsight_warnings)

add_executable(prove_run prove_run.cpp)
target_link_libraries(prove_run PRIVATE armsight_proof armsight_command_line armsight_warnings)
