#include "host/joint_fit.hpp"

#include <cmath>
#include <numbers>

#include "host/text.hpp"

namespace armsight::host {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kLeastTurn_rad = 0.0087;   // half a degree: less was no turn, or another joint's
constexpr double kWorstScale_share = 0.05;  // a scale not known to this is none to move by
constexpr double kLargestScale = 50.0;

std::string deg(double rad) { return fixed(degrees(rad), 2) + " deg"; }

/// How far the three places are off a straight line: an answer that does not belong to the others.
double bow(const JointAnswers& a, const JointReadings& r, double slope) {
  const double middle_true = (a.up_rad + a.down_rad) / 2.0, middle_reading = (r.up_rad + r.down_rad) / 2.0;
  return a.here_rad - middle_true - slope * (r.here_rad - middle_reading);
}

std::string contradiction(const JointAnswers& a, const JointReadings& r, double tolerance_rad) {
  const double moved = r.up_rad - r.down_rad, turned = a.up_rad - a.down_rad;
  if (std::abs(moved) < kLeastTurn_rad) return "it did not turn: " + deg(moved) + " by its encoder";
  if (std::abs(turned) < 2.0 * tolerance_rad)
    return "its angles say that it turned by " + deg(turned) + ", no more than they are exact (--tolerance-deg)";
  if (a.turned_positive != (a.up_rad > a.here_rad))
    return std::string("it is said to have turned ") + (a.turned_positive ? "in" : "against") +
           " its positive direction, but its angle went from " + deg(a.here_rad) + " to " + deg(a.up_rad);
  const double off = bow(a, r, turned / moved);
  if (std::abs(off) > 1.5 * tolerance_rad)
    return "its three angles do not fit its encoder: " + deg(a.down_rad) + ", " + deg(a.here_rad) + ", " +
           deg(a.up_rad) + " are " + deg(off) + " off a line, more than their exactness allows (--tolerance-deg)";
  if (std::abs(turned / moved) > kLargestScale || std::abs(turned / moved) < 1.0 / kLargestScale)
    return "it turned by " + deg(turned) + " where the robot file promised " + deg(moved);
  return {};
}

std::string broken_limits(const JointAnswers& a, double min_rad, double max_rad) {
  if (a.free_min_rad > min_rad || a.free_max_rad < max_rad)
    return "the robot file lets it turn from " + deg(min_rad) + " to " + deg(max_rad) + ", it is free from " +
           deg(a.free_min_rad) + " to " + deg(a.free_max_rad) + " only: narrow min_rad and max_rad";
  if (a.here_rad < min_rad || a.here_rad > max_rad)
    return "it stands at " + deg(a.here_rad) + ", beyond the limits " + deg(min_rad) + " to " + deg(max_rad) +
           ": bring it inside by hand, power off";
  return {};
}

/// A gear's ratio is a whole number, or one over it, more often than what 4° of turning can tell: where just one fits.
double likely_ratio(double scale, double sigma) {
  const double ratio = scale > 1.0 ? scale : 1.0 / scale, ratio_sigma = sigma / scale * ratio;
  const double whole = std::round(ratio);
  if (ratio_sigma > 0.4 || std::abs(ratio - whole) > ratio_sigma) return scale;
  return scale > 1.0 ? whole : 1.0 / whole;
}

/// The scale that is in force from now on; a text where the measurement is too coarse for one.
std::string take_scale(double slope, double sigma, const DriveConfig& drive, JointFit& fit) {
  fit.scale_sigma = sigma;
  fit.counts_per_turn = drive.counts_per_turn;
  fit.gear = drive.gear;
  const double scale = std::abs(slope);
  if (std::abs(scale - 1.0) <= sigma) return {};
  const std::string found = "it turned " + fixed(scale, 3) + " times as far as the robot file says";
  if (drive.family == DriveFamily::kDamiao)
    return found + ": position_range_rad is not its drive's, or a gear lies between";
  if (sigma / scale > kWorstScale_share)
    return found + ", known to " + fixed(100.0 * sigma / scale, 0) +
           " % only: measure its angles more exactly (--tolerance-deg)";
  fit.scale = likely_ratio(scale, sigma);
  fit.counts_per_turn = drive.counts_per_turn / fit.scale;
  fit.gear = drive.gear / fit.scale;
  return {};
}

}  // namespace

std::variant<JointFit, std::string> fit_joint(const JointAnswers& answers, const JointReadings& readings,
                                              const DriveConfig& drive, double min_rad, double max_rad,
                                              double tolerance_rad) {
  if (const std::string no = contradiction(answers, readings, tolerance_rad); !no.empty()) return no;
  if (const std::string no = broken_limits(answers, min_rad, max_rad); !no.empty()) return no;
  const double moved = readings.up_rad - readings.down_rad;
  const double slope = (answers.up_rad - answers.down_rad) / moved;
  JointFit fit;
  if (const std::string no = take_scale(slope, 2.0 * tolerance_rad / std::abs(moved), drive, fit); !no.empty())
    return no;
  fit.sign = slope > 0.0 ? drive.sign : -drive.sign;
  // Of the drive's own turns, of all three places: the zero is as exact as their mean.
  const double reading = (readings.here_rad + readings.up_rad + readings.down_rad) / 3.0;
  const double truth = (answers.here_rad + answers.up_rad + answers.down_rad) / 3.0;
  const double turns_rad = drive.sign * (reading - drive.zero_rad) * fit.scale;
  fit.zero_rad = truth - fit.sign * turns_rad;
  if (std::abs(fit.zero_rad) > kTurn_rad)
    return "its zero would lie at " + deg(fit.zero_rad) + ", beyond a turn: preset the drive's encoder";
  return fit;
}

}  // namespace armsight::host
