#include "host/commission.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>

#include "host/joint_fit.hpp"
#include "host/motion.hpp"
#include "host/robot_file_edit.hpp"
#include "host/text.hpp"
#include "protocol/atomic_file.hpp"
#include "protocol/strict_yaml.hpp"

namespace armsight::host {
namespace {

constexpr double kTurn_rad = 2.0 * kDegree;
constexpr double kStopAfter_rad = 0.5 * kDegree;    // on the way, at full speed
constexpr double kLongestStop_rad = 0.5 * kDegree;  // 2°/s for the link's 50 ms and the drive's ramp, five times over
constexpr double kMostDrift_rad = 0.1 * kDegree;
constexpr Duration kStopTimeout = std::chrono::seconds(3);
constexpr Duration kDriftTime = std::chrono::milliseconds(500);

class JointSession {
 public:
  JointSession(HostIo& io, Operator& person, const CommissionOptions& options, std::size_t joint, std::ostream& out)
      : io_(io), person_(person), options_(options), joint_(joint), name_(io.robot().joint_names[joint]), out_(out) {}

  JointFit run() {
    start_rad_ = reading();
    JointAnswers answers;
    JointReadings readings;
    out_ << name_ << ": will turn by 2 deg, up and down, at most at 2 deg/s" << std::endl;
    ask_angle("here_deg", "at which angle does it stand?", answers.here_rad, readings.here_rad);
    turn_to(kTurn_rad);
    answers.turned_positive = person_.ask_yes(name_, "positive", "did it turn in its positive direction?");
    ask_angle("up_deg", "at which angle does it stand now?", answers.up_rad, readings.up_rad);
    turn_to(-kTurn_rad);
    ask_angle("down_deg", "and at which now?", answers.down_rad, readings.down_rad);
    turn_to(0.0);
    const auto [low, high] =
        person_.ask_range_deg(name_, "free_deg", "from where to where do mechanics and cables let it turn?");
    answers.free_min_rad = low * kDegree;
    answers.free_max_rad = high * kDegree;
    const JointFit fit = judge(answers, readings);
    try_stop();
    turn_to(0.0);
    tell(fit);
    return fit;
  }

 private:
  double reading() { return reading_now(io_)[static_cast<Eigen::Index>(joint_)]; }
  [[noreturn]] void fail(const std::string& why) { throw CommandFailed("commission: " + name_ + ": " + why); }

  void ask_angle(const std::string& key, const std::string& text, double& angle_rad, double& reading_rad) {
    angle_rad = person_.ask_deg(name_, key, text) * kDegree;
    reading_rad = reading();
  }

  MotionResult turn(double from_start_rad, const std::function<bool()>& is_over = {}) {
    MotionOptions options;
    options.is_over = is_over;
    options.commission_joint = static_cast<int>(joint_) + 1;
    JointVector q = real_now(io_);
    q[static_cast<Eigen::Index>(joint_)] += start_rad_ + from_start_rad - reading();
    return drive_to(io_, q, options);
  }
  void turn_to(double from_start_rad) {
    const MotionResult motion = turn(from_start_rad);
    if (!motion.has_arrived) fail(motion.why);
  }

  JointFit judge(const JointAnswers& answers, const JointReadings& readings) {
    const JointLimits& limits = io_.robot().arm.limits;
    const auto i = static_cast<Eigen::Index>(joint_);
    const auto fit = fit_joint(answers, readings, io_.robot().drives[joint_], limits.min_rad[i], limits.max_rad[i],
                               options_.tolerance_rad);
    if (const std::string* why = std::get_if<std::string>(&fit)) fail(*why);
    return std::get<JointFit>(fit);
  }

  // The drive's own ramp, as after a fault: it must stop at once and then hold.
  void try_stop() {
    const MotionResult cut = turn(kTurn_rad, [this] { return std::abs(reading() - start_rad_) > kStopAfter_rad; });
    if (cut.why != "cut short")
      fail("could not be stopped under way: " + (cut.has_arrived ? "it was there already" : cut.why));
    const double asked_at = reading();
    const Time asked = io_.now();
    wire::Envelope message;
    message.mutable_mode_request()->set_mode(wire::MODE_READY);
    message.mutable_mode_request()->set_quick_stop(true);
    io_.demand(std::move(message), "quick stop");
    const auto is_over = [this] {
      const auto& state = *io_.arm().state();
      return state.mode() == wire::MODE_READY && state.is_still();
    };
    if (!io_.wait_until(is_over, kStopTimeout)) fail("did not stop within 3 s of a quick stop");
    const double stopped_at = reading();
    stop_rad_ = std::abs(stopped_at - asked_at);
    stop_s_ = to_seconds(io_.now() - asked);
    if (stop_rad_ > kLongestStop_rad)
      fail("went on for " + fixed(degrees(stop_rad_), 2) + " deg after a quick stop, more than " +
           fixed(degrees(kLongestStop_rad), 1));
    io_.wait_until([] { return false; }, kDriftTime);
    const double drift = std::abs(reading() - stopped_at);
    if (drift > kMostDrift_rad)
      fail("sank by " + fixed(degrees(drift), 2) + " deg after a quick stop: its drive does not hold");
    take_command(io_, false);
  }

  void tell(const JointFit& fit) {
    const DriveConfig& old = io_.robot().drives[joint_];
    out_ << name_ << ": sign " << fit.sign
         << (fit.sign == old.sign ? " as it was" : " (was " + std::to_string(old.sign) + ")") << ", scale "
         << (fit.scale == 1.0 ? "as it was" : "times " + fixed(fit.scale, 4)) << " (known to "
         << fixed(100.0 * fit.scale_sigma / fit.scale, 1) << " %), zero " << fixed(degrees(fit.zero_rad), 2)
         << " deg (was " << fixed(degrees(old.zero_rad), 2) << "), limits free, stops within "
         << fixed(degrees(stop_rad_), 2) << " deg and " << fixed(1e3 * stop_s_, 0) << " ms, holds" << std::endl;
  }

  HostIo& io_;
  Operator& person_;
  const CommissionOptions& options_;
  std::size_t joint_;
  std::string name_;
  std::ostream& out_;
  double start_rad_ = 0.0, stop_rad_ = 0.0, stop_s_ = 0.0;
};

}  // namespace

std::vector<std::size_t> joints_to_commission(const RobotConfig& robot, const std::vector<std::string>& names) {
  std::vector<std::size_t> out;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(robot.joint_names, name);
    if (found == robot.joint_names.end()) throw ConfigError("--joint: " + name + ": is no joint of " + robot.robot);
    const auto joint = static_cast<std::size_t>(found - robot.joint_names.begin());
    if (robot.drives[joint].is_commissioned)
      throw ConfigError("--joint: " + name + ": is commissioned; to do it again take that word out of the robot file");
    if (std::ranges::find(out, joint) != out.end()) throw ConfigError("--joint: " + name + ": is named twice");
    out.push_back(joint);
  }
  for (std::size_t i = 0; names.empty() && i < robot.drives.size(); ++i)
    if (!robot.drives[i].is_commissioned) out.push_back(i);
  if (out.empty()) throw ConfigError("commission: every joint of " + robot.robot + " is commissioned already");
  return out;
}

void run_commission(HostIo& io, Operator& person, const CommissionOptions& options, std::ostream& out) {
  std::map<std::size_t, JointFit> fits;
  for (const std::size_t joint : options.joints)
    fits.emplace(joint, JointSession(io, person, options, joint, out).run());
  write_file_atomically(options.out_file,
                        with_commissioned(read_text_file(options.robot_file), options.robot_file, fits));
  out << "commissioned: " << fits.size() << " joints, in " << options.out_file
      << "; start the controller with it, and give it to the host (--robot)" << std::endl;
}

void show_commission(const RobotConfig& robot, const CommissionOptions& options, std::ostream& out) {
  for (const std::size_t joint : options.joints)
    out << "commission: " << robot.joint_names[joint]
        << ": would turn by 2 deg up, 4 deg down and 2 deg up, at most at 2 deg/s, "
        << "then once more and be stopped by its drive" << std::endl;
  out << "commission: would write " << options.out_file << std::endl;
}

}  // namespace armsight::host
