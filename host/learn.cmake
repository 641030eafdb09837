# Learn: the batch calibration and everything a data set needs. Ceres only in batch_calibration_c*.cpp.
add_library(armsight_host_learn STATIC
  batch_calibration.cpp
  batch_calibration_ceres.cpp
  batch_calibration_cost.cpp
  batch_calibration_refine.cpp
  chain_kinematics.cpp
  chain_problem.cpp
  chain_unknowns.cpp
  closed_form_starts.cpp
  cross_validation.cpp
  csv_table.cpp
  dataset.cpp
  dataset_chains.cpp
  dataset_columns.cpp
  dataset_csv.cpp
  dataset_pictures.cpp
  dataset_yaml.cpp
  learn_arm.cpp
  learn_arm_verdict.cpp
  learn_cost.cpp
  learn_dataset.cpp
  learn_dataset_report.cpp
  look_weight.cpp
  model_blocks.cpp
  nested_validation.cpp
  noise_estimate.cpp
  observability.cpp
  pinhole_projection.cpp
  robot_description.cpp
  stream_alignment.cpp
  urdf_import.cpp)
target_link_libraries(armsight_host_learn
  PUBLIC armsight_core armsight_protocol armsight_host_vision
  PRIVATE Ceres::ceres PkgConfig::urdfdom opencv_calib3d opencv_imgcodecs opencv_imgproc
          nlohmann_json::nlohmann_json armsight_warnings)
