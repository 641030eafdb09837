// A problem with everything in it: a camera on a chain of two joints, one target on a chain of five, one fixed to the
// root; corners or poses. Shared by the tests of Learn.
#pragma once

#include "host/batch_calibration.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::host::test_problem {

inline Pose random_pose(double size_m, double angle_rad, std::mt19937& random) {
  return {so3_exp(test::random_vector(angle_rad, random)), test::random_vector(size_m, random)};
}

inline ChainModel two_chain_model(std::mt19937& random) {
  ChainModel model;
  model.chains.push_back({"head", test::general_chain(2, 3), {0, 1}, false});
  model.chains.push_back({"arm", test::general_chain(5, 4), {2, 3, 4, 5, 6}, false});
  for (int j = 0; j < 7; ++j) model.offsets.push_back({"joint_" + std::to_string(j), 0.02 * j, Freedom::kFree, 0, 0});
  model.camera_chain = 0;
  model.T_C_a = {"the camera on head", random_pose(0.1, 0.5, random), Freedom::kFree, {}, 0, 0};
  ProblemTarget hand, board;
  hand.name = "hand";
  hand.chain = 1;
  hand.T_b_M = {"the mount of hand", random_pose(0.05, 0.5, random), Freedom::kFree, {}, 0, 0};
  hand.scale = {"hand", 0.97, Freedom::kFree, 1, 0};
  board.name = "board";
  board.T_b_M = {"the place of board", random_pose(0.5, 0.3, random), Freedom::kFree, {}, 0, 0};
  board.scale = {"board", 1.02, Freedom::kFree, 1, 0};
  model.targets = {hand, board};
  model.camera = {640, 480, 500, 510, 320, 240, {-0.1, 0.02, 0.001, -0.002, 0.003}};
  return model;
}

/// The same with every other kind of unknown free too: axes, intrinsics, the looks' clock.
inline ChainModel everything_free(std::mt19937& random) {
  ChainModel model = two_chain_model(random);
  for (std::size_t j = 0; j < model.offsets.size(); ++j) {
    AxisUnknown axis;
    axis.value << test::random_vector(0.01, random).head<2>(), test::random_vector(0.05, random).head<2>();
    axis.freedom = Freedom::kPrior;
    axis.prior_sigma_m = 0.003;
    axis.prior_sigma_rad = 0.01;
    model.axes.push_back(axis);
  }
  model.camera_unknown.freedom = Freedom::kPrior;
  model.camera_unknown.prior = to_vector(model.camera);
  model.camera_unknown.prior_sigma << 15, 15, 15, 15, 0.1, 0.1, 0.005, 0.005, 0.1;
  model.time_offset.freedom = Freedom::kFree;
  model.time_offset.value = 0.02;
  return model;
}

inline Observation random_observation(const ChainModel& model, int target, bool corners, std::mt19937& random) {
  Observation z;
  z.target = target;
  z.q = Eigen::VectorXd::Zero(7);
  for (int j = 0; j < 7; ++j) z.q[j] = test::random_vector(0.5, random)[0];
  z.R_vision = Matrix6::Identity() * 1e-6;
  const Pose predicted = predicted_T_C_M(model, z);
  z.T_C_M = {so3_exp(test::random_vector(0.3, random)) * predicted.R, predicted.p + test::random_vector(0.05, random)};
  if (!corners) return z;
  z.sigma_px = 0.3;
  for (int k = 0; k < 4; ++k) {
    z.points_M.push_back(test::random_vector(0.02, random));
    z.pixels.push_back({300.0 + 10 * k, 200.0 - 5 * k});
  }
  return z;
}

/// Shifts the camera until the target stands in front of it.
inline void put_in_front(ChainModel& model, const Observation& z) {
  model.T_C_a.value.p += Vector3(0.05, -0.03, 1.0) - predicted_T_C_M(model, z).p;
}

}  // namespace armsight::host::test_problem
