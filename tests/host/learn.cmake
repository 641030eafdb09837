# Tests of Learn: the estimator on synthetic looks, then on other people's data.
add_armsight_test(host_learn_tests LABEL unit TIMEOUT 300
  SOURCES learn_arm_test.cpp learn_chain_problem_test.cpp learn_dataset_format_test.cpp learn_urdf_test.cpp
          learn_urdf_arms_test.cpp learn_datasets_test.cpp learn_likelihood_test.cpp learn_proof_test.cpp
  LIBS armsight_host_learn armsight_convert armsight_proof armsight_test_looks Ceres::ceres
       nlohmann_json::nlohmann_json)
target_compile_definitions(host_learn_tests PRIVATE ARMSIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
