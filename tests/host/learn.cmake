# Tests of Learn: the estimator on synthetic looks, then on other people's data.
add_armsight_test(host_learn_tests LABEL unit
  SOURCES learn_arm_test.cpp learn_chain_problem_test.cpp learn_dataset_format_test.cpp learn_urdf_test.cpp
          ../shared/simulated_looks.cpp
  LIBS armsight_host_learn armsight_convert)

add_armsight_test(host_learn_data_tests LABEL unit TIMEOUT 300
  SOURCES learn_datasets_test.cpp
  LIBS armsight_host_learn armsight_convert)
foreach(program host_learn_tests host_learn_data_tests)
  target_compile_definitions(${program} PRIVATE ARMSIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
endforeach()
