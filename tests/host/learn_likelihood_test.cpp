// What Learn makes small, and whether it is made smallest: Jacobians against automatic differentiation of a model
// written a second time, weights against their definition, the optimum against Ceres', noise and blocks against truth.
#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "host/batch_calibration_refine.hpp"
#include "host/model_blocks.hpp"
#include "host/noise_estimate.hpp"
#include "tests/host/two_chains.hpp"

namespace armsight::host {
namespace {

using namespace test_problem;
using Kind = UnknownBlock::Kind;

constexpr int kMostColumns = 80;
using Jet = ceres::Jet<double, kMostColumns>;
using JetVector = Eigen::Matrix<Jet, 3, 1>;
using JetMatrix = Eigen::Matrix<Jet, 3, 3>;

struct JetPose {
  JetMatrix R;
  JetVector p;
};
JetPose operator*(const JetPose& a, const JetPose& b) { return {a.R * b.R, a.R * b.p + a.p}; }
JetPose jet(const Pose& T) { return {T.R.cast<Jet>(), T.p.cast<Jet>()}; }
JetPose inverse(const JetPose& T) { return {T.R.transpose(), -(T.R.transpose() * T.p)}; }
JetMatrix turn(const JetVector& w) {
  JetMatrix R;
  ceres::AngleAxisToRotationMatrix(w.data(), R.data());  // column-major, as Eigen's
  return R;
}

/// The measurement model once more, from the words of host/chain_problem.hpp, with x the steps of all columns.
class Model {
 public:
  Model(const ChainModel& model, const Observation& z, const LookUnknowns& columns)
      : model_(model), z_(z), columns_(columns) {}

  Eigen::Matrix<Jet, Eigen::Dynamic, 1> pixels() const {
    const auto& target = model_.targets[static_cast<std::size_t>(z_.target)];
    const JetPose T_C_a = jet(model_.T_C_a.value) * step(0);
    const JetPose T_b_M = step(6) * jet(target.T_b_M.value);
    const JetPose T_C_M = T_C_a * inverse(end(model_.camera_chain)) * end(target.chain) * T_b_M;
    const Jet scale = target.scale.value + at(columns_.scale);
    Eigen::Matrix<Jet, Eigen::Dynamic, 1> pixels(2 * static_cast<Eigen::Index>(z_.points_M.size()));
    for (std::size_t k = 0; k < z_.points_M.size(); ++k) {
      const JetVector p = T_C_M.R * (z_.points_M[k].cast<Jet>() * scale) + T_C_M.p;
      pixels.segment<2>(static_cast<Eigen::Index>(2 * k)) = project(p);
    }
    return pixels;
  }

 private:
  Jet at(int column) const { return {0.0, column}; }
  JetPose step(int column) const {
    const JetVector v(at(column), at(column + 1), at(column + 2)), w(at(column + 3), at(column + 4), at(column + 5));
    return {turn(w), v};
  }
  JetPose end(int index) const {
    JetPose T = jet({});
    if (index == kRoot) return T;
    const ProblemChain& chain = model_.chains[static_cast<std::size_t>(index)];
    T = jet(chain.chain.T_B_0);
    for (std::size_t i = 0; i < chain.joints.size(); ++i) {
      const int joint = chain.joints[i], position = columns_.joint_position(joint);
      const auto& axis = model_.axes[static_cast<std::size_t>(joint)].value;
      const int c = columns_.axis[static_cast<std::size_t>(position)];
      const JetVector shift(axis[0] + at(c), axis[1] + at(c + 1), Jet(0.0));
      const JetVector tilt(axis[2] + at(c + 2), axis[3] + at(c + 3), Jet(0.0));
      const Jet elapsed = model_.time_offset.value - z_.at_offset_s + at(columns_.time);
      const Jet q = z_.q[joint] + model_.offsets[static_cast<std::size_t>(joint)].value +
                    at(LookUnknowns::kFirstOffset + position) + elapsed * z_.q_rate[joint];
      T = T * JetPose{turn(tilt), shift} * JetPose{turn(JetVector(Jet(0.0), Jet(0.0), q)), JetVector::Zero()} *
          jet(chain.chain.T_after[i]);
    }
    return T;
  }
  Eigen::Matrix<Jet, 2, 1> project(const JetVector& p) const {
    const IntrinsicsVector k = to_vector(model_.camera);
    const auto value = [&](int i) { return k[i] + at(columns_.intrinsics + i); };
    const Jet x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const Jet radial = 1.0 + value(4) * r2 + value(5) * r2 * r2 + value(8) * r2 * r2 * r2;
    const Jet xd = x * radial + 2.0 * value(6) * x * y + value(7) * (r2 + 2.0 * x * x);
    const Jet yd = y * radial + value(6) * (r2 + 2.0 * y * y) + 2.0 * value(7) * x * y;
    return {value(0) * xd + value(2), value(1) * yd + value(3)};
  }

  const ChainModel& model_;
  const Observation& z_;
  const LookUnknowns& columns_;
};

TEST(Likelihood, ItsJacobiansAreThoseOfAutomaticDifferentiation) {
  std::mt19937 random(21);
  ChainModel model = everything_free(random);
  for (int k = 0; k < 10; ++k) {
    Observation z = random_observation(model, k % 2, true, random);
    z.q_rate = Eigen::VectorXd::LinSpaced(7, -0.5, 1.0);
    put_in_front(model, z);
    const LookUnknowns columns = look_unknowns(model, z.target);
    ASSERT_LE(columns.columns, kMostColumns);
    const auto residual = residual_of(model, z, columns);
    ASSERT_TRUE(residual);
    const auto pixels = Model(model, z, columns).pixels();
    for (Eigen::Index row = 0; row < pixels.size(); ++row) {
      const double measured = z.pixels[static_cast<std::size_t>(row / 2)][row % 2];
      EXPECT_NEAR(residual->r[row], measured - pixels[row].a, 1e-9);
      EXPECT_LT((residual->J.row(row).transpose() + pixels[row].v.head(columns.columns)).norm(),
                1e-9 * (1.0 + residual->J.row(row).norm()));
    }
  }
}

TEST(Likelihood, WeighsCornersByPixelsEncodersAndFloor) {
  std::mt19937 random(22);
  ChainModel model = two_chain_model(random);
  const NoiseModel noise{0.002, 0.001, 0.005};
  const Observation z = random_observation(model, 0, true, random);
  put_in_front(model, z);
  const LookUnknowns columns = look_unknowns(model, 0);
  const auto residual = residual_of(model, z, columns);
  const Eigen::MatrixXd J_q = residual->J.middleCols(LookUnknowns::kFirstOffset, 7);
  Vector6 floor;
  floor << Vector3::Constant(1e-6), Vector3::Constant(25e-6);
  const Eigen::MatrixXd R = 0.09 * Eigen::MatrixXd::Identity(8, 8) + 4e-6 * J_q * J_q.transpose() +
                            residual->G * floor.asDiagonal() * residual->G.transpose();
  const double squared = (LookWeight(model, z, noise) * residual->r).squaredNorm();
  EXPECT_NEAR(squared, residual->r.dot(R.inverse() * residual->r), 1e-9 * squared);
}

TEST(Likelihood, TheThesisCostIsTheOnePrinted) {
  std::mt19937 random(23);
  ChainModel model = two_chain_model(random);
  Observation z = random_observation(model, 0, false, random);
  model.targets[0].scale.value = 1.0;
  const Observation seen = observations_for(LearnCost::kThesis, model, {z})[0];
  const auto r = residual_only(model, seen);
  const Pose T = predicted_T_C_M(model, z);
  Eigen::Quaterniond quat = Eigen::Quaterniond(z.T_C_M.R) * Eigen::Quaterniond(T.R).conjugate();
  if (quat.w() < 0.0) quat.coeffs() *= -1.0;
  EXPECT_LT((r->head<3>() - (z.T_C_M.p - T.p)).norm(), 1e-12);
  EXPECT_LT((r->tail<3>() - quat.vec()).norm(), 1e-12);
  const Eigen::VectorXd whitened = LookWeight(model, seen, {}) * *r;
  EXPECT_LT((whitened - whitened.norm() / r->norm() * *r).norm(), 1e-9 * whitened.norm());  // no weights
  EXPECT_LT(jacobian_disagreement(model, {seen}, {}), 1e-6);
}

/// Looks at both targets with corner noise; every target in front of the camera.
std::vector<Observation> corner_looks(const ChainModel& truth, int count, double sigma_px, std::mt19937& random) {
  std::vector<Observation> looks;
  std::normal_distribution<double> noise(0.0, sigma_px);
  while (static_cast<int>(looks.size()) < count) {
    Observation z = random_observation(truth, static_cast<int>(looks.size()) % 2, true, random);
    z.T_C_M = predicted_T_C_M(truth, z);
    z.points_M = {{-0.03, 0.03, 0}, {0.03, 0.03, 0}, {0.03, -0.03, 0}, {-0.03, -0.03, 0}, {0, 0, 0.01}};
    z.pixels.clear();
    const double scale = truth.targets[static_cast<std::size_t>(z.target)].scale.value;
    for (const Vector3& point : z.points_M) {
      const auto p = project_with_jacobian(truth.camera, z.T_C_M * Vector3(scale * point));
      if (p && p->pixel.minCoeff() > 0.0 && p->pixel.maxCoeff() < 640.0) {
        z.pixels.push_back(p->pixel + Eigen::Vector2d(noise(random), noise(random)));
      }
    }
    z.sigma_px = std::max(sigma_px, 0.01);
    if (z.pixels.size() == z.points_M.size()) looks.push_back(z);
  }
  return looks;
}

/// Unit scales, the gauges of camera, hand and board held.
ChainModel plain_truth(std::mt19937& random) {
  ChainModel model = two_chain_model(random);
  for (auto& target : model.targets) target.scale = {target.name, 1.0, Freedom::kFixed, 1.0, 0.0};
  model.targets[1].T_b_M.value.p += Vector3(0, 0, 0.2);
  Observation z;
  z.q = Eigen::VectorXd::Zero(7);
  model.T_C_a.value.p += Vector3(0, 0, 1.5) - predicted_T_C_M(model, z).p;
  model.camera.plumb_bob = {};
  return model;
}

TEST(Likelihood, OurSolverAndCeresFindTheSameOptimum) {
  std::mt19937 random(24);
  ChainModel truth = plain_truth(random);
  const auto looks = corner_looks(truth, 30, 0.3, random);
  BlockOptions blocks;
  blocks.offset_joints = {0, 2, 3, 4, 5};
  ChainModel start =
      with_blocks(truth, {ModelBlock::kLinks, ModelBlock::kScale, ModelBlock::kIntrinsics}, blocks);
  start.T_C_a.value.p += Vector3(0.01, -0.02, 0.01);
  for (const RobustLoss loss : {RobustLoss::kNone, RobustLoss::kHuber, RobustLoss::kCauchy}) {
    BatchOptions options;
    options.noise = {0.001, 0.0005, 0.002};
    options.loss = loss;
    options.max_iterations = 300;
    const std::vector<char> used(looks.size(), 1);
    const Refined ours = refine(start, looks, used, options, 2.0);
    const Refined theirs = refine_by_ceres(start, looks, used, options, 2.0);
    EXPECT_TRUE(ours.converged);
    for (const auto& z : looks) {
      EXPECT_LT(pose_error(predicted_T_C_M(ours.model, z), predicted_T_C_M(theirs.model, z)).norm(), 1e-7);
    }
  }
}

TEST(NoiseEstimate, FindsThePixelsOfTheCorners) {
  std::mt19937 random(25);
  const ChainModel truth = plain_truth(random);
  const auto looks = corner_looks(truth, 100, 0.2, random);
  EXPECT_NEAR(estimated_sigma_px(truth, looks, std::vector<char>(looks.size(), 1)), 0.2, 0.04);
}

TEST(NoiseEstimate, FindsTheFloorDespiteOutliers) {
  std::mt19937 random(27);
  const ChainModel truth = plain_truth(random);
  std::vector<Observation> looks;
  for (int i = 0; i < 200; ++i) {
    Observation z = random_observation(truth, i % 2, false, random);
    const Pose exact = predicted_T_C_M(truth, z);
    const double wild = i % 10 == 0 ? 30.0 : 1.0;
    z.T_C_M = {so3_exp(test::random_vector(wild * 0.004, random)) * exact.R,
               exact.p + test::random_vector(wild * 0.002, random)};
    z.R_vision.setZero();
    looks.push_back(z);
  }
  const NoiseModel found = estimated_floor(truth, looks, std::vector<char>(looks.size(), 1), {0.0, 0.02, 0.05});
  EXPECT_NEAR(found.floor_position_sigma_m, 0.002, 0.0004);
  EXPECT_NEAR(found.floor_rotation_sigma_rad, 0.004, 0.0008);
}

/// What Learn switches on for this truth, told the nominal robot `believed`.
std::string chosen_for(const ChainModel& truth, const ChainModel& believed, unsigned seed) {
  std::mt19937 random(seed);
  const auto looks = corner_looks(truth, 40, 0.2, random);
  BatchOptions batch;
  batch.noise = {0.0, 0.001, 0.005};
  batch.estimates_noise = true;
  BlockOptions blocks;
  blocks.allowed = {ModelBlock::kOffsets, ModelBlock::kScale, ModelBlock::kLinks, ModelBlock::kIntrinsics};
  blocks.offset_joints = {0, 2, 3, 4, 5};
  const BatchSolution learnt = learn(believed, looks, batch);
  const BlockChoice choice = choose_blocks(believed, learnt, looks, batch, blocks);
  return name_of(choice.tried[choice.chosen].blocks);
}

TEST(ModelBlocks, AreSwitchedOnWhereTheyAreWrongAndOnlyThere) {
  std::mt19937 random(26);
  ChainModel believed = plain_truth(random);
  for (auto& offset : believed.offsets) offset = {offset.name, 0.0, Freedom::kFixed, 0.0, 0.0};
  EXPECT_EQ(chosen_for(believed, believed, 1), "mounts only");
  ChainModel truth = believed;
  truth.offsets[3].value = 0.03;
  truth.offsets[4].value = -0.02;
  EXPECT_EQ(chosen_for(truth, believed, 2), "+ offsets");
  truth = believed;
  truth.targets[0].scale.value = 0.96;
  EXPECT_NE(chosen_for(truth, believed, 3).find("scale"), std::string::npos);
  truth = believed;
  truth.axes.resize(7);
  truth.axes[4].value << 0.004, -0.003, 0.01, 0.006;
  EXPECT_NE(chosen_for(truth, believed, 4).find("links"), std::string::npos);
  truth = believed;
  truth.camera.fx *= 1.03;
  truth.camera.plumb_bob[0] = -0.1;
  EXPECT_NE(chosen_for(truth, believed, 5).find("intrinsics"), std::string::npos);
}

}  // namespace
}  // namespace armsight::host
