#include "host/small_verbs.hpp"

#include <cmath>
#include <ostream>

#include "host/json_out.hpp"
#include "host/motion.hpp"
#include "host/text.hpp"
#include "protocol/atomic_file.hpp"

namespace armsight::host {
namespace {

constexpr double kPosePosition_m = 0.001;
constexpr Duration kStiffnessTimeout = std::chrono::seconds(2);
constexpr Duration kStopTimeout = std::chrono::seconds(5);
constexpr Duration kAnswerTimeout = std::chrono::milliseconds(1200);

}  // namespace

void run_move(HostIo& io, SessionFiles& files, const JointVector& q_real, const std::optional<Pose>& T_B_G,
              std::ostream& progress) {
  MoveRecord record;
  MotionResult motion;
  if (T_B_G) {
    record.T_B_G = T_B_G;
    const PoseTarget target{wire::GOAL_FRAME_BASE,    *T_B_G,      model_in_force(io).revision, kPosePosition_m,
                            kMovePoseOrientation_rad, real_now(io)};
    motion = drive_to(io, target);
  } else {
    record.q_goal_real = q_real;
    motion = drive_to(io, q_real);
  }
  record.status = motion.status;
  record.state = motion.has_arrived ? "arrived" : motion.why;
  record.model = model_in_force(io);
  if (motion.has_arrived) {  // as it stands, not as it came to the goal's tolerance
    record.status.set_arm_time_ns(io.arm().state()->arm_time_ns());
    *record.status.mutable_q_reading_rad() = io.arm().state()->q_reading_rad();
  }
  files.save_result(to_json(record));
  if (!motion.has_arrived) throw CommandFailed("move: " + motion.why);
  progress << "arrived: joints " << degrees_text(real_now(io)) << " deg, "
           << fixed(motion.status.position_error_m() * 1e3, 2) << " mm, "
           << fixed(degrees(motion.status.orientation_error_rad()), 2) << " deg from the goal" << std::endl;
}

void run_hand(HostIo& io, double closure, double force_permille, std::ostream& progress) {
  const HandResult hand = move_hand(io, closure, force_permille);
  progress << "hand: fingers at " << fixed(100 * hand.closure, 0) << " % with " << fixed(hand.effort_permille / 10, 0)
           << " % of their force" << std::endl;
}

std::vector<std::uint32_t> stiffness_of(const std::vector<double>& permille, const RobotConfig& robot) {
  const std::size_t joints = robot.drives.size();
  if (permille.size() != 1 && permille.size() != joints)
    throw ConfigError("stiffness: " + std::to_string(permille.size()) + " values: must be one, or one a joint, " +
                      std::to_string(joints));
  std::vector<std::uint32_t> out(joints);
  bool is_taken = false;
  for (std::size_t i = 0; i < joints; ++i) {
    out[i] = static_cast<std::uint32_t>(std::lround(permille[permille.size() == 1 ? 0 : i]));
    is_taken = is_taken || robot.takes_stiffness(i);
  }
  if (!is_taken)
    throw ConfigError("stiffness: no drive of " + robot.robot + " can be told: family damiao, or stiffness_object");
  return out;
}

void run_stiffness(HostIo& io, const std::vector<std::uint32_t>& permille, std::ostream& out) {
  wire::Envelope lease, message;
  lease.mutable_lease_request();
  io.demand(std::move(lease), "lease");
  for (const std::uint32_t value : permille) message.mutable_stiffness_command()->add_permille(value);
  io.demand(std::move(message), "stiffness");
  const RobotConfig& robot = io.robot();
  const auto is_there = [&] {
    const auto& now = io.arm().state()->stiffness_permille();
    for (int i = 0; i < static_cast<int>(permille.size()); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (robot.takes_stiffness(k) && (now.size() <= i || now[i] != permille[k])) return false;
    }
    return true;
  };
  if (!io.wait_until(is_there, kStiffnessTimeout)) throw CommandFailed("stiffness: not in force after 2 s");
  std::string set, left;
  for (std::size_t i = 0; i < permille.size(); ++i) {
    std::string& text = robot.takes_stiffness(i) ? set : left;
    text += (text.empty() ? "" : ", ") + robot.joint_names[i];
    if (robot.takes_stiffness(i)) text += " " + std::to_string(permille[i]);
  }
  out << "stiffness: " << set << " per mille" << std::endl;
  if (!left.empty())
    out << "stiffness: DEGRADED: " << left << " stay as they are, their drives cannot be told" << std::endl;
}

void run_black_box(HostIo& io, const std::filesystem::path& file, std::ostream& out) {
  std::string bytes, name;
  while (true) {
    wire::Envelope request;
    request.mutable_black_box_request()->set_offset(bytes.size());
    io.arm().send(std::move(request));
    std::optional<wire::BlackBoxChunk> chunk;
    if (!io.wait_until([&] { return (chunk = io.arm().take_black_box_chunk()).has_value(); }, kAnswerTimeout))
      throw CommandFailed("blackbox: no answer; the controller may be older than this host");
    if (chunk->name().empty()) throw CommandFailed("blackbox: there is none: no fault since the controller started");
    const bool is_next =
        chunk->offset() == bytes.size() && !chunk->data().empty() && (name.empty() || name == chunk->name());
    if (!is_next) throw CommandFailed("blackbox: another fault came while it was fetched; fetch again");
    name = chunk->name();
    bytes += chunk->data();
    if (bytes.size() >= chunk->total_bytes()) break;
  }
  write_file_atomically(file, bytes);
  out << "black box: " << name << ", " << bytes.size() << " bytes, in " << file.string() << "\n"
      << "           go through it again: link_replay " << file.string() << std::endl;
}

void run_stop(HostIo& io, std::ostream& out) {
  wire::Envelope stop;
  stop.mutable_stop()->set_reason("the operator asked for it");
  io.demand(std::move(stop), "stop");
  const auto rests = [&] {
    const auto& state = io.arm().state();
    return state && state->mode() != wire::MODE_SERVO && state->mode() != wire::MODE_STOPPING;
  };
  if (!io.wait_until(rests, kStopTimeout)) {
    if (!io.arm().state()) throw PeerLost("arm controller: took the stop, but tells no state");
    throw CommandFailed("stop: the arm still moves after 5 s");
  }
  out << "stopped: " << to_text(io.arm().state()->mode()) << std::endl;
}

}  // namespace armsight::host
