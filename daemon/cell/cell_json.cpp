#include "daemon/cell/cell_json.hpp"

#include <algorithm>
#include <boost/json/value.hpp>

#include "daemon/cell/stream_trouble.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace json = boost::json;

namespace {

json::value text_or_null(const std::string& text) { return text.empty() ? json::value{} : json::value(text); }

/// Not validated = no number.
json::value error_or_null(double mean_mm) { return mean_mm > 0 ? json::value(mean_mm) : json::value{}; }

std::string address(const config::Endpoint& endpoint) {
  return endpoint.host + ":" + std::to_string(endpoint.port);
}

/// Without a model the correction goes to zero, and nothing is corrected from then on.
std::string_view modelless_state_name(const StreamStatus& status) {
  const bool zero = std::ranges::all_of(status.correction_deg, [](double axis_deg) { return axis_deg == 0; });
  return zero ? "waiting" : "ramping";
}

/// A stream without packets waits, whatever it did before.
std::string_view stream_state_name(const StreamStatus& status, bool streaming, bool silent) {
  switch (status.state) {
    case StreamState::Fault:
      return "fault";
    case StreamState::Idle:
      return streaming ? "waiting" : "off";
    case StreamState::Unproven:
      return "waiting";
    case StreamState::RampingIn:
    case StreamState::RampingOut:
      return silent ? "waiting" : "ramping";
    case StreamState::Active:
      if (silent) return "waiting";
      return status.model == 0 ? modelless_state_name(status) : "correcting";
    case StreamState::Frozen:
      return "holding";
  }
  return "fault";
}

json::value ms_or_null(std::optional<drivers::Duration> age) {
  if (!age) return {};
  return std::chrono::duration_cast<std::chrono::milliseconds>(*age).count();
}

std::string stream_reason(const StreamStatus& status, const StreamSurroundings& around, bool silent) {
  if (const std::string why = reason(status); !why.empty()) return why;
  if (!around.trouble.empty() || !around.streaming) return around.trouble;
  if (silent) return old_packet_text(status, around.age);
  return status.model == 0 ? "no model is active: nothing is corrected; activate one, or stop the stream"
                           : "";
}

}  // namespace

json::array vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string_view purpose_name(PointPurpose purpose) {
  switch (purpose) {
    case PointPurpose::Identify:
      return "identify";
    case PointPurpose::Validate:
      return "validate";
    case PointPurpose::Reference:
      return "reference";
    case PointPurpose::Remeasure:
      return "remeasure";
    case PointPurpose::Target:
      return "target";
    case PointPurpose::Cycle:
      return "cycle";
  }
  return "remeasure";
}

json::object campaign_json(const CampaignRecord& record) {
  return {{"id", record.id},
          {"kind", record.kind},
          {"started", record.started},
          {"ended", text_or_null(record.ended)},
          {"state", record.state},
          {"reason", record.reason},
          {"robot_model", record.robot_model},
          {"robot_serial", record.robot_serial},
          {"tracker_model", record.tracker_model},
          {"tracker_serial", record.tracker_serial},
          {"model_id", text_or_null(record.model_id)}};
}

json::object skipped_json(const SkippedPose& skipped) {
  return {{"pose", skipped.pose}, {"reason", skipped.reason}, {"attempts", skipped.attempts}};
}

json::object point_json(const RobotModel& robot, const StoredPoint& point) {
  return {{"pose", point.pose},
          {"purpose", purpose_name(point.purpose)},
          {"smr", point.smr},
          {"q_target_deg", record::joints_json(point.q_target, robot)},
          {"q_commanded_deg", record::joints_json(point.q_commanded, robot)},
          {"q_actual_deg", record::joints_json(point.q_actual, robot)},
          {"p_mm", vector_json(point.p_WS_mm)},
          {"std_mm", vector_json(point.std_mm)},
          {"time", point.time}};
}

json::object model_json(const ModelRecord& record) {
  return {{"id", record.id},
          {"created", record.created},
          {"campaign_id", record.campaign_id},
          {"robot_serial", record.robot_serial},
          {"validation_before_mm", error_or_null(record.validation_before_mm)},
          {"validation_after_mm", error_or_null(record.validation_after_mm)},
          {"active", record.active}};
}

json::object parameter_json(const IdentifiedParameter& parameter) {
  return {{"name", parameter.name},
          {"nominal", parameter.nominal},
          {"value", parameter.value},
          {"sigma", parameter.sigma},
          {"identified", parameter.identified}};
}

json::object config_json(const config::CellConfig& config) {
  return {{"name", config.name},
          {"robot",
           {{"file", config.robot.file.string()},
            {"model", config.robot.model.name},
            {"eki_motion", address(config.robot.eki_motion)},
            {"eki_state", address(config.robot.eki_state)},
            {"expect_model", config.robot.expect_model}}},
          {"stream",
           {{"listen", address(config.stream.listen)},
            {"ethernet_xml", config.stream.ethernet_xml.string()},
            {"max_step_deg", config.stream.max_step_deg},
            {"max_total_deg", config.stream.max_total_deg},
            {"ramp_ms", config.stream.ramp.count()}}},
          {"tracker",
           {{"address", address(config.tracker.address)},
            {"reflector", config.tracker.reflector},
            {"search_mm", config.tracker.search_mm},
            {"gate_mm", config.tracker.gate_mm}}},
          {"campaign",
           {{"identify_poses", config.campaign.identify_poses},
            {"validate_poses", config.campaign.validate_poses},
            {"seed", config.campaign.seed},
            {"speed_percent", config.campaign.speed_percent},
            {"remeasure", config.campaign.remeasure}}},
          {"control", {{"listen", address(config.control.listen)}}},
          {"store", config.store.string()}};
}

json::object fault_json(const Fault& fault) {
  return {{"code", fault.code}, {"severity", fault.severity}, {"text", fault.text}, {"since", fault.since}};
}

json::object stream_json(const StreamStatus& status, const LatencyHistogram::Summary& turnaround,
                         const StreamSurroundings& around) {
  const StreamCounters& c = status.counters;
  const bool silent = !around.age || *around.age >= kSilence;
  json::array correction_deg, measured_deg;
  if (status.state != StreamState::Idle) {
    for (const double axis_deg : status.correction_deg) correction_deg.emplace_back(axis_deg);
    for (const auto& axis_deg : status.measured_deg) {
      measured_deg.emplace_back(axis_deg && !silent ? json::value(*axis_deg) : json::value{});
    }
  }
  return {
      {"state", stream_state_name(status, around.streaming, silent)},
      {"reason", stream_reason(status, around, silent)},
      {"model_id", text_or_null(around.model_id)},
      {"peer", status.peer ? json::value(text(*status.peer)) : json::value{}},
      {"packet_age_ms", ms_or_null(around.age)},
      {"ipoc_step", c.datagrams > 0 && status.ipoc_step > 0 ? json::value(status.ipoc_step) : json::value{}},
      {"sessions", c.sessions},
      {"cycles", c.datagrams},
      {"answered", c.replies()},
      {"held", c.held},
      {"duplicate", c.duplicate},
      {"unproven", c.unproven},
      {"wrong_ipoc", c.wrong_ipoc},
      {"malformed", c.malformed},
      {"partly_read", c.partly_read},
      {"foreign", c.foreign},
      {"refused", text_or_null(around.refused)},
      {"late", c.late},
      {"lost", c.lost},
      {"clamped", c.clamped_step + c.clamped_total + c.clamped_limit + c.clamped_not_finite},
      {"no_solution", c.no_solution},
      {"damped", c.damped},
      {"max_step_deg", status.max_step_deg},
      {"correction_deg", std::move(correction_deg)},
      {"measured_deg", std::move(measured_deg)},
      {"turnaround_us",
       {{"p50", turnaround.p50_us},
        {"p99", turnaround.p99_us},
        {"p999", turnaround.p999_us},
        {"max", turnaround.max_us}}}};
}

}  // namespace truepose::daemon
