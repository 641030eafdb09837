#include "tools/replay/envelope_fields.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace armsight::replay {
namespace {

class FieldList {
 public:
  explicit FieldList(std::string prefix) : prefix_(std::move(prefix)) {}

  FieldList& number(const char* name, double value) { return add(name, value); }
  template <typename Integer>
  FieldList& integer(const char* name, Integer value) {
    return add(name, static_cast<std::int64_t>(value));
  }
  FieldList& text(const char* name, const std::string& value) { return add(name, value); }
  FieldList& numbers(const char* name, const google::protobuf::RepeatedField<double>& values) {
    integer((std::string(name) + ".size").c_str(), values.size());
    for (int i = 0; i < values.size(); ++i)
      number((std::string(name) + "[" + std::to_string(i) + "]").c_str(), values[i]);
    return *this;
  }
  FieldList& vector(const std::string& name, const wire::Vector3& v) {
    return number((name + ".x").c_str(), v.x())
        .number((name + ".y").c_str(), v.y())
        .number((name + ".z").c_str(), v.z());
  }
  FieldList& pose(const std::string& name, const wire::Pose& p) {
    number((name + ".x_m").c_str(), p.x_m())
        .number((name + ".y_m").c_str(), p.y_m())
        .number((name + ".z_m").c_str(), p.z_m());
    number((name + ".qw").c_str(), p.qw()).number((name + ".qx").c_str(), p.qx());
    return number((name + ".qy").c_str(), p.qy()).number((name + ".qz").c_str(), p.qz());
  }
  std::vector<Field> take() { return std::move(fields_); }

 private:
  template <typename Value>
  FieldList& add(const char* name, Value value) {
    fields_.push_back({prefix_ + "." + name, std::move(value)});
    return *this;
  }
  std::string prefix_;
  std::vector<Field> fields_;
};

void list(const wire::HelloReply& m, FieldList& out) {
  out.integer("protocol_version", m.protocol_version()).text("program", m.program());
  out.integer("model_hash", m.model_hash()).integer("lease_ns", m.lease_ns()).text("robot", m.robot());
  out.integer("joint_count", m.joint_count()).number("rate_hz", m.rate_hz()).text("bus", m.bus());
}

void list(const wire::HeartbeatReply& m, FieldList& out) {
  out.integer("host_send_time_ns", m.host_send_time_ns()).integer("arm_receive_time_ns", m.arm_receive_time_ns());
  out.integer("arm_send_time_ns", m.arm_send_time_ns());
}

void list(const wire::Refusal& m, FieldList& out) {
  out.integer("refused_sequence", m.refused_sequence()).integer("reason", m.reason()).text("text", m.text());
}

void list(const wire::ArmState& m, FieldList& out) {
  out.integer("arm_time_ns", m.arm_time_ns()).integer("mode", m.mode()).numbers("q_reading_rad", m.q_reading_rad());
  out.numbers("speed_rad_s", m.speed_rad_s()).numbers("q_command_rad", m.q_command_rad());
  out.numbers("torque_Nm", m.torque_nm()).number("hand_closure", m.hand_closure());
  out.number("hand_effort_permille", m.hand_effort_permille()).integer("hand_is_moving", m.hand_is_moving());
  out.integer("is_still", m.is_still()).integer("model_revision", m.model_revision()).integer("goal", m.goal());
  out.integer("fault_code", m.fault_code()).integer("has_lease", m.has_lease());
}

void list(const wire::GoalStatus& m, FieldList& out) {
  out.integer("goal", m.goal()).integer("state", m.state()).number("position_error_m", m.position_error_m());
  out.number("orientation_error_rad", m.orientation_error_rad()).integer("model_revision", m.model_revision());
  out.integer("arm_time_ns", m.arm_time_ns()).numbers("q_reading_rad", m.q_reading_rad()).text("text", m.text());
}

void list(const wire::ModelUpdate& m, FieldList& out) {
  out.integer("revision", m.revision()).pose("base_in_camera", m.base_in_camera()).numbers("beta_rad", m.beta_rad());
  out.numbers("covariance", m.covariance()).text("source", m.source()).integer("arm_time_ns", m.arm_time_ns());
}

void list(const wire::FilterReport& m, FieldList& out) {
  out.integer("outcome", m.outcome()).numbers("innovation", m.innovation()).number("nis", m.nis());
  out.number("cost", m.cost()).number("gain_norm", m.gain_norm()).integer("iterations", m.iterations());
  out.integer("model_revision", m.model_revision()).vector("delta_t_m", m.delta_t_m());
  out.vector("delta_theta_rad", m.delta_theta_rad()).numbers("delta_beta_rad", m.delta_beta_rad());
  out.integer("arm_capture_time_ns", m.arm_capture_time_ns()).numbers("q_reading_rad", m.q_reading_rad());
  out.numbers("hand_sigma", m.hand_sigma());
}

void list(const wire::FaultReport& m, FieldList& out) {
  out.integer("code", m.code()).text("text", m.text()).text("side", m.side()).integer("arm_time_ns", m.arm_time_ns());
}

void list(const wire::ControllerStatistics& m, FieldList& out) {
  out.number("rate_hz", m.rate_hz()).integer("cycles", m.cycles()).integer("missed", m.missed());
  out.integer("looks_overflowed", m.looks_overflowed()).integer("protocol_errors", m.protocol_errors());
  out.integer("events_lost", m.events_lost()).integer("ticks_unrecorded", m.ticks_unrecorded());
  out.integer("link_unrecorded", m.link_unrecorded());
}

std::string to_text(const Field& field) {
  if (const auto* integer = std::get_if<std::int64_t>(&field.value)) return std::to_string(*integer);
  if (const auto* text = std::get_if<std::string>(&field.value)) return "\"" + *text + "\"";
  char text[40];
  std::snprintf(text, sizeof text, "%.12g", std::get<double>(field.value));
  return text;
}

bool is_same(const Field& a, const Field& b) {
  if (a.name != b.name || a.value.index() != b.value.index()) return false;
  if (const auto* x = std::get_if<double>(&a.value)) return std::abs(*x - std::get<double>(b.value)) <= kSameValue;
  return a.value == b.value;
}

}  // namespace

std::string body_name(const wire::Envelope& e) {
  switch (e.body_case()) {
    case wire::Envelope::kHelloReply: return "hello_reply";
    case wire::Envelope::kHeartbeatReply: return "heartbeat_reply";
    case wire::Envelope::kRefusal: return "refusal";
    case wire::Envelope::kAccepted: return "accepted";
    case wire::Envelope::kBye: return "bye";
    case wire::Envelope::kArmState: return "arm_state";
    case wire::Envelope::kGoalStatus: return "goal_status";
    case wire::Envelope::kModelUpdate: return "model_update";
    case wire::Envelope::kFilterReport: return "filter_report";
    case wire::Envelope::kFaultReport: return "fault_report";
    case wire::Envelope::kStatistics: return "statistics";
    default: return "message " + std::to_string(static_cast<int>(e.body_case()));
  }
}

std::vector<Field> repeatable_fields(const wire::Envelope& e) {
  FieldList out(body_name(e));
  switch (e.body_case()) {
    case wire::Envelope::kHelloReply: list(e.hello_reply(), out); break;
    case wire::Envelope::kHeartbeatReply: list(e.heartbeat_reply(), out); break;
    case wire::Envelope::kRefusal: list(e.refusal(), out); break;
    case wire::Envelope::kAccepted: out.integer("accepted_sequence", e.accepted().accepted_sequence()); break;
    case wire::Envelope::kArmState: list(e.arm_state(), out); break;
    case wire::Envelope::kGoalStatus: list(e.goal_status(), out); break;
    case wire::Envelope::kModelUpdate: list(e.model_update(), out); break;
    case wire::Envelope::kFilterReport: list(e.filter_report(), out); break;
    case wire::Envelope::kFaultReport: list(e.fault_report(), out); break;
    case wire::Envelope::kStatistics: list(e.statistics(), out); break;
    default: break;
  }
  out.integer("sent_time_ns", e.sent_time_ns()).integer("sequence", e.sequence());
  return out.take();
}

std::optional<FieldDifference> first_difference(const wire::Envelope& recorded, const wire::Envelope& replayed) {
  if (recorded.body_case() != replayed.body_case())
    return FieldDifference{"message", body_name(recorded), body_name(replayed)};
  const std::vector<Field> a = repeatable_fields(recorded), b = repeatable_fields(replayed);
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (!is_same(a[i], b[i])) return FieldDifference{a[i].name, to_text(a[i]), to_text(b[i])};
  return std::nullopt;
}

}  // namespace armsight::replay
