#include "host/chain_kinematics.hpp"

#include <cmath>

namespace armsight::host {
namespace {

/// Since the time at which the look's posture was looked up; 0 where the clock offset is no unknown.
double elapsed_s(const ChainModel& model, const Observation& z) {
  return model.time_offset.freedom == Freedom::kFixed ? 0.0 : model.time_offset.value - z.at_offset_s;
}

double angle_of(const ChainModel& model, int joint, const Observation& z) {
  const double q = z.q[joint] + model.offsets[static_cast<std::size_t>(joint)].value;  // (4.3)
  return z.q_rate.size() > 0 ? q + elapsed_s(model, z) * z.q_rate[joint] : q;
}

Pose given_pose(const ChainModel& model, const Observation& z) {
  const double dt_s = elapsed_s(model, z);
  if (dt_s == 0.0) return z.T_0_given;
  return {so3_exp(dt_s * z.given_rate.tail<3>()) * z.T_0_given.R, z.T_0_given.p + dt_s * z.given_rate.head<3>()};
}

/// T Rz(q).
void turn_about_z(double q, Pose& T) {
  const double c = std::cos(q), s = std::sin(q);
  const Vector3 x = T.R.col(0), y = T.R.col(1);
  T.R.col(0) = c * x + s * y;
  T.R.col(1) = c * y - s * x;
}

bool has_axis(const ChainModel& model, int joint) {
  return !model.axes.empty() && model.axes[static_cast<std::size_t>(joint)].value.squaredNorm() > 0.0;
}

/// Column of a motion: velocity of the point, then turn rate.
void add_column(const Vector3& velocity, const Vector3& turn, double sign, const Matrix3& R_C_0, Eigen::Index column,
                Eigen::MatrixXd& J) {
  J.block<3, 1>(0, column) += sign * (R_C_0 * velocity);
  J.block<3, 1>(3, column) += sign * (R_C_0 * turn);
}

void add_axis_columns(const JointFrame& frame, double sign, const Vector3& p_0, const Matrix3& R_C_0, int column,
                      Eigen::MatrixXd& J) {
  for (int k = 0; k < 2; ++k) {
    add_column(frame.R_0_before.col(k), Vector3::Zero(), sign, R_C_0, column + k, J);
    const Vector3 turn = frame.turn.col(k);
    add_column(turn.cross(p_0 - frame.origin), turn, sign, R_C_0, column + 2 + k, J);
  }
}

}  // namespace

Pose end_pose(const ChainModel& model, int chain_index, const Observation& z) {
  if (chain_index == kRoot) return {};
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (chain.is_given) return given_pose(model, z);
  Pose T = chain.chain.T_B_0;
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const int joint = chain.joints[i];
    if (has_axis(model, joint)) T = T * model.axes[static_cast<std::size_t>(joint)].correction();
    turn_about_z(angle_of(model, joint, z), T);
    T = T * chain.chain.T_after[i];
  }
  return T;
}

ChainMotion end_motion(const ChainModel& model, int chain_index, const Observation& z) {
  ChainMotion motion;
  if (chain_index == kRoot) return motion;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (chain.is_given) {
    motion.T_0_e = given_pose(model, z);
    return motion;
  }
  motion.count = static_cast<int>(chain.joints.size());
  Pose T = chain.chain.T_B_0;
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const int joint = chain.joints[i];
    JointFrame& frame = motion.joints[i];
    frame.R_0_before = T.R;
    frame.turn = T.R;
    if (has_axis(model, joint)) {
      const AxisUnknown& axis = model.axes[static_cast<std::size_t>(joint)];
      frame.turn = T.R * so3_left_jacobian(Vector3(axis.value[2], axis.value[3], 0.0));
      T = T * axis.correction();
    }
    frame.axis = T.R.col(2);
    frame.origin = T.p;
    turn_about_z(angle_of(model, joint, z), T);
    T = T * chain.chain.T_after[i];
  }
  motion.T_0_e = T;
  return motion;
}

void add_motion_columns(const ChainModel& model, int chain_index, const Observation& z, const ChainMotion& motion,
                        double sign, const Vector3& p_0, const Matrix3& R_C_0, const LookUnknowns& columns,
                        Eigen::MatrixXd& J) {
  if (chain_index == kRoot) return;
  const ProblemChain& chain = model.chains[static_cast<std::size_t>(chain_index)];
  if (chain.is_given && columns.time >= 0) {
    const Vector3 turn = z.given_rate.tail<3>();
    add_column(z.given_rate.head<3>() + turn.cross(p_0 - motion.T_0_e.p), turn, sign, R_C_0, columns.time, J);
  }
  for (int i = 0; i < motion.count; ++i) {
    const JointFrame& frame = motion.joints[static_cast<std::size_t>(i)];
    const int joint = chain.joints[static_cast<std::size_t>(i)];
    const int position = columns.joint_position(joint);
    const Vector3 velocity = frame.axis.cross(p_0 - frame.origin);
    add_column(velocity, frame.axis, sign, R_C_0, LookUnknowns::kFirstOffset + position, J);
    if (columns.time >= 0 && z.q_rate.size() > 0) {
      add_column(z.q_rate[joint] * velocity, z.q_rate[joint] * frame.axis, sign, R_C_0, columns.time, J);
    }
    if (columns.axis.empty() || columns.axis[static_cast<std::size_t>(position)] < 0) continue;
    add_axis_columns(frame, sign, p_0, R_C_0, columns.axis[static_cast<std::size_t>(position)], J);
  }
}

}  // namespace armsight::host
