// Kinematics, servo step and inverse kinematics beside Orocos KDL, the library that most arms are programmed with.
// Answers are compared before times: a row whose answers differ holds nothing.
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <numbers>

#include "shared/inverse_kinematics.hpp"
#include "shared/pose_servo.hpp"
#include "tests/bench/bench_row.hpp"
#include "tests/shared/default_arm.hpp"

namespace armsight::bench {
namespace {

using namespace test;

constexpr std::size_t kInputs = 1000;
constexpr double kCycle_s = 0.004;

KDL::Chain kdl_arm() {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  const double dh[5][4] = {{0, kQuarter, 0, 0},
                           {0, -kQuarter, 0, kQuarter},
                           {0, -kQuarter, 0.168, -kQuarter},
                           {0, kQuarter, 0, 0},
                           {0, -kQuarter, 0.185, 0}};  // table 7.1: a, α, d, θ
  KDL::Chain chain;
  for (const auto& row : dh)
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ), KDL::Frame::DH(row[0], row[1], row[2], row[3])));
  return chain;
}

KDL::JntArray to_kdl(const JointVector& q) {
  KDL::JntArray array(static_cast<unsigned>(q.size()));
  for (Eigen::Index i = 0; i < q.size(); ++i) array(static_cast<unsigned>(i)) = q[i];
  return array;
}

KDL::Frame to_kdl(const Pose& T) {
  KDL::Frame frame(KDL::Vector(T.p.x(), T.p.y(), T.p.z()));
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.M(r, c) = T.R(r, c);
  return frame;
}

std::vector<KDL::Frame> to_kdl(const std::vector<Pose>& poses) {
  std::vector<KDL::Frame> frames;
  for (const Pose& T : poses) frames.push_back(to_kdl(T));
  return frames;
}

Pose from_kdl(const KDL::Frame& frame) {
  Pose T;
  for (int r = 0; r < 3; ++r) {
    T.p[r] = frame.p(r);
    for (int c = 0; c < 3; ++c) T.R(r, c) = frame.M(r, c);
  }
  return T;
}

struct Postures {
  std::vector<JointVector> ours;
  std::vector<KDL::JntArray> kdl;
};

Postures random_postures(const JointVector& min, const JointVector& max, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  Postures postures;
  for (std::size_t i = 0; i < count; ++i) {
    postures.ours.push_back(random_between(min, max, random));
    postures.kdl.push_back(to_kdl(postures.ours.back()));
  }
  return postures;
}

Row ratio_row(const std::string& name, const Paired& time, double least_ratio, bool answers_agree) {
  Row row{name,         "us",
          time.ours_us, time.peer_us,
          "Orocos KDL", "at least " + std::to_string(int(least_ratio)) + " times faster",
          {},           {}};
  row.holds = answers_agree && time.peer_us >= least_ratio * time.ours_us;
  if (!answers_agree) row.why = "the answers differ from the peer's";
  return row;
}

Row forward_row(int blocks) {
  const ArmModel arm = default_arm();
  const KDL::Chain chain = kdl_arm();
  KDL::ChainFkSolverPos_recursive fk(chain);
  KDL::ChainJntToJacSolver jacobian(chain);
  const Postures at = random_postures(arm.limits.min_rad, arm.limits.max_rad, kInputs, 1);
  KDL::Frame frame;
  KDL::Jacobian J(5);
  bool agree = true;
  for (std::size_t i = 0; i < kInputs; ++i) {
    const HandKinematics hand = hand_kinematics(arm.chain, at.ours[i]);
    fk.JntToCart(at.kdl[i], frame);
    jacobian.JntToJac(at.kdl[i], J);
    agree = agree && (from_kdl(frame).R - hand.T_B_H.R).norm() < 1e-9 &&
            (from_kdl(frame).p - hand.T_B_H.p).norm() < 1e-9 && (J.data - hand.J).norm() < 1e-9;
  }
  const Paired time = time_paired(
      kInputs, blocks, [&](std::size_t i) { keep(hand_kinematics(arm.chain, at.ours[i])); },
      [&](std::size_t i) {
        fk.JntToCart(at.kdl[i], frame);
        jacobian.JntToJac(at.kdl[i], J);
        keep(J);
      });
  return ratio_row("FK + Jacobian, 5 joints", time, 6.0, agree);
}

/// A goal a few millimetres away that the arm can meet.
std::vector<Pose> goals_nearby(const ArmModel& arm, const Postures& at, double step_rad) {
  std::mt19937 random(2);
  std::vector<Pose> goals;
  for (const JointVector& q : at.ours) {
    const JointVector step =
        random_between(JointVector::Constant(5, -step_rad), JointVector::Constant(5, step_rad), random);
    goals.push_back(forward_kinematics(arm.chain, q + step));
  }
  return goals;
}

std::vector<Row> servo_rows(int blocks) {
  ArmModel arm = default_arm();
  const KDL::Chain chain = kdl_arm();
  KDL::ChainIkSolverVel_pinv velocity(chain);
  KDL::ChainFkSolverPos_recursive fk(chain);
  const Postures at = random_postures(arm.limits.min_rad, arm.limits.max_rad, kInputs, 3);
  const JointVector none = JointVector::Constant(5, 1e9), minus_none = -none;
  const PoseServoOptions options;
  KDL::JntArray speeds(5);
  const auto step_of_kdl = [&](std::size_t i, const std::vector<KDL::Frame>& goals) {
    KDL::Frame hand;
    fk.JntToCart(at.kdl[i], hand);
    velocity.CartToJnt(at.kdl[i], KDL::diff(hand, goals[i], 1.0 / options.gain_per_s), speeds);
  };
  const auto without_limits = [&](std::size_t i, const std::vector<Pose>& goals) {
    return pose_servo_speeds(arm.chain, at.ours[i], goals[i], minus_none, none, none, kCycle_s, options);
  };

  // Where the arm is far from singular and the step small, both must give the same speeds.
  const std::vector<Pose> near = goals_nearby(arm, at, 1e-5);
  const std::vector<KDL::Frame> near_of_kdl = to_kdl(near);
  bool agree = true;
  for (std::size_t i = 0; i < kInputs; ++i) {
    if (position_manipulability(arm.chain, at.ours[i]) < 0.15) continue;
    step_of_kdl(i, near_of_kdl);
    agree = agree && (speeds.data - without_limits(i, near)).norm() <= 0.01 * speeds.data.norm();
  }
  const std::vector<Pose> goals = goals_nearby(arm, at, 0.3);  // about three joints meet a bound
  const std::vector<KDL::Frame> goals_of_kdl = to_kdl(goals);
  const Work kdl = [&](std::size_t i) {
    step_of_kdl(i, goals_of_kdl);
    keep(speeds);
  };
  const Paired limited = time_paired(
      kInputs, blocks,
      [&](std::size_t i) {
        keep(pose_servo_speeds(arm.chain, at.ours[i], goals[i], arm.limits.min_rad, arm.limits.max_rad,
                               arm.limits.max_speed_rad_s, kCycle_s, options));
      },
      kdl);
  const Paired free = time_paired(
      kInputs, blocks, [&](std::size_t i) { keep(without_limits(i, goals)); }, kdl);
  std::vector<Row> rows{ratio_row("servo step with limits QP against KDL's velocity IK", limited, 5.0, agree),
                        ratio_row("servo step without QP against KDL's velocity IK", free, 15.0, agree)};
  for (Row& row : rows)
    if (row.why.empty()) row.why = "both from joint angles and a goal pose to joint speeds";
  return rows;
}

struct IkScore {
  double solved_percent = 0.0, mean_us = 0.0;
};

template <class Solve>
IkScore score(std::size_t count, const Solve& solve) {
  std::size_t solved = 0;
  const double start = thread_time_us();
  for (std::size_t i = 0; i < count; ++i) solved += solve(i) ? 1 : 0;
  return {100.0 * static_cast<double>(solved) / static_cast<double>(count),
          (thread_time_us() - start) / static_cast<double>(count)};
}

std::string in_words(const IkScore& s) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f %% solved, %.1f us", s.solved_percent, s.mean_us);
  return text;
}

bool is_inside(const KDL::JntArray& q, const JointVector& min, const JointVector& max) {
  for (unsigned i = 0; i < 5; ++i)
    if (q(i) < min[i] - 1e-9 || q(i) > max[i] + 1e-9) return false;
  return true;
}

/// 3000 reachable poses, seed posture at random; solved: position to 1e-5 m and 1e-4 rad, inside the limits.
Row ik_row(const std::string& limits, const JointVector& min, const JointVector& max, std::size_t count) {
  const ArmModel arm = default_arm();
  const KDL::Chain chain = kdl_arm();
  const Postures at = random_postures(min, max, count, 4), seeds = random_postures(min, max, count, 5);
  std::vector<Pose> goals;
  for (const JointVector& q : at.ours) goals.push_back(forward_kinematics(arm.chain, q));
  const auto is_met = [&](std::size_t i, const JointVector& q) {
    const Vector6 e = pose_error(goals[i], forward_kinematics(arm.chain, q));
    return e.head<3>().norm() <= 1e-5 && e.tail<3>().norm() <= 1e-4 && (q - min).minCoeff() >= 0.0 &&
           (max - q).minCoeff() >= 0.0;
  };
  const IkScore ours = score(count, [&](std::size_t i) {
    const auto solution = solve_ik(arm.chain, min, max, goals[i], seeds.ours[i], {.limit_margin_rad = 0.0});
    return solution && is_met(i, solution->q);
  });
  KDL::JntArray q(5);
  KDL::ChainIkSolverPos_LMA lma(chain);
  const IkScore kdl_lma = score(count, [&](std::size_t i) {
    return lma.CartToJnt(seeds.kdl[i], to_kdl(goals[i]), q) >= 0 && is_inside(q, min, max);
  });
  KDL::ChainFkSolverPos_recursive fk(chain);
  KDL::ChainIkSolverVel_pinv velocity(chain);
  KDL::ChainIkSolverPos_NR_JL nr_jl(chain, to_kdl(min), to_kdl(max), fk, velocity, 100, 1e-5);
  const IkScore kdl_nr =
      score(count, [&](std::size_t i) { return nr_jl.CartToJnt(seeds.kdl[i], to_kdl(goals[i]), q) >= 0; });
  Row row{"IK inside limits, " + std::to_string(count) + " reachable poses, " + limits,
          "us",
          ours.mean_us,
          kdl_lma.mean_us,
          "KDL LMA",
          "100 % solved, mean at most 25 us",
          {},
          {}};
  row.holds = ours.solved_percent == 100.0 && ours.mean_us <= 25.0;
  row.why = "ours " + in_words(ours) + "; LMA " + in_words(kdl_lma) + "; NR_JL " + in_words(kdl_nr);
  return row;
}

}  // namespace

std::vector<Row> kinematics_rows(bool is_quick) {
  const int blocks = is_quick ? 3 : 41;
  const std::size_t poses = is_quick ? 100 : 3000;
  std::vector<Row> rows{forward_row(blocks)};
  for (const Row& row : servo_rows(blocks)) rows.push_back(row);
  const JointLimits limits = default_arm().limits;
  rows.push_back(ik_row("limits +-2 rad", JointVector::Constant(5, -2.0), JointVector::Constant(5, 2.0), poses));
  rows.push_back(ik_row("the default arm's limits", limits.min_rad, limits.max_rad, poses));
  return rows;
}

}  // namespace armsight::bench
