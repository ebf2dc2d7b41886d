#include "daemon/web/daemon_metrics.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <string_view>

#include "daemon/cell/cell_state.hpp"
#include "daemon/web/metrics_text.hpp"

namespace truepose::daemon {

namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
}

void write_process(MetricsText& text, const DaemonMeasures& measures) {
  text.family("truepose_info", "gauge", "Which daemon this is; always 1");
  text.sample(1, {{"version", TRUEPOSE_VERSION}, {"cell", measures.cell}});
  text.gauge("truepose_uptime_seconds", "Since the daemon was started", measures.uptime.count());
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  text.counter("process_cpu_seconds_total", "Processor time used",
               seconds(used.ru_utime) + seconds(used.ru_stime));
  long pages = 0, resident = 0;
  std::ifstream{"/proc/self/statm"} >> pages >> resident;
  text.gauge("process_resident_memory_bytes", "Memory in use",
             static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)));
}

void write_cell(MetricsText& text, const DaemonCell::Snapshot& cell) {
  text.family("truepose_cell_state", "gauge", "1 for the state that the cell is in");
  for (const std::string_view state : kStateNames)
    text.sample(state == cell.state ? 1 : 0, {{"state", state}});
  text.family("truepose_faults", "gauge", "Faults that stand");
  text.sample(static_cast<double>(cell.warnings), {{"severity", "warning"}});
  text.sample(static_cast<double>(cell.errors), {{"severity", "error"}});
  text.family("truepose_device_connected", "gauge", "Whether the device is connected");
  text.sample(cell.robot_connected, {{"device", "robot"}});
  text.sample(cell.tracker_connected, {{"device", "tracker"}});
  text.gauge("truepose_robot_ready", "Whether the robot may be moved", cell.robot_ready);
  text.gauge("truepose_model_active", "Whether a model is active", cell.model.has_value());
  if (!cell.model || cell.model->validation_after_mm <= 0) return;
  text.family("truepose_model_validation_millimeters", "gauge",
              "Mean error of the active model's validation");
  text.sample(cell.model->validation_before_mm, {{"arm", "nominal"}});
  text.sample(cell.model->validation_after_mm, {{"arm", "calibrated"}});
}

void write_campaign(MetricsText& text, const std::optional<CampaignProgress>& campaign) {
  text.gauge("truepose_campaign_running", "Whether a campaign is under way", campaign.has_value());
  if (!campaign) return;
  text.family("truepose_campaign_poses", "gauge", "Poses of the campaign under way");
  text.sample(campaign->done, {{"state", "done"}});
  text.sample(campaign->skipped, {{"state", "skipped"}});
  text.sample(campaign->left(), {{"state", "left"}});
  if (campaign->error_mm)
    text.gauge("truepose_campaign_error_millimeters", "Mean distance from the prediction in this phase",
               *campaign->error_mm);
}

void write_stream_counters(MetricsText& text, const StreamCounters& counters) {
  const auto count = [](std::uint64_t number) { return static_cast<double>(number); };
  text.counter("truepose_stream_cycles_total", "Datagrams of the controller", count(counters.datagrams));
  text.counter("truepose_stream_sessions_total", "Starts of the controller's side", count(counters.sessions));
  text.family("truepose_stream_replies_total", "counter", "Replies, by the correction that they carried");
  text.sample(count(counters.answered), {{"kind", "answered"}});
  text.sample(count(counters.held), {{"kind", "held"}});
  text.sample(count(counters.duplicate), {{"kind", "repeated"}});
  text.family("truepose_stream_unanswered_total", "counter",
              "Datagrams that were not answered, by the reason");
  text.sample(count(counters.unconfirmed), {{"reason", "unconfirmed"}});
  text.sample(count(counters.wrong_ipoc), {{"reason", "wrong_ipoc"}});
  text.sample(count(counters.unanswered), {{"reason", "malformed"}});
  text.counter("truepose_stream_malformed_total", "Datagrams that could not be believed",
               count(counters.malformed));
  text.counter("truepose_stream_unexpected_sender_total", "Datagrams of others than the controller",
               count(counters.unexpected_sender));
  text.counter("truepose_stream_lost_total", "Cycles missing in the controller's IPOC", count(counters.lost));
  text.counter("truepose_stream_late_total", "Replies that the controller did not have in time",
               count(counters.late));
  text.family("truepose_stream_late_by_total", "counter", "Late replies, by what held them up");
  text.sample(count(counters.late_by_daemon), {{"cause", "daemon"}});
  text.sample(count(counters.late_by_machine), {{"cause", "machine"}});
  text.sample(count(counters.late_by_network), {{"cause", "network"}});
  text.family("truepose_stream_clamped_total", "counter", "Corrections cut at a bound");
  text.sample(count(counters.clamped_step), {{"limit", "step"}});
  text.sample(count(counters.clamped_total), {{"limit", "total"}});
  text.sample(count(counters.clamped_limit), {{"limit", "joint_limit"}});
  text.sample(count(counters.clamped_not_finite), {{"limit", "not_finite"}});
  text.counter("truepose_stream_no_solution_total", "Cycles in which the calibrated arm was not inverted",
               count(counters.no_solution));
  text.counter("truepose_stream_damped_total", "Cycles that gave up orientation next to a wrist singularity",
               count(counters.damped));
}

void write_stream(MetricsText& text, const StreamCycle& stream, drivers::TimePoint now, bool armed) {
  static constexpr std::array kEdges_us{25.0,   50.0,   100.0,  200.0,  300.0,   500.0,  1000.0,
                                        2000.0, 3000.0, 4000.0, 8000.0, 12000.0, 50000.0};
  const StreamStatus status = stream.status();
  text.family("truepose_stream_state", "gauge", "1 for the state that the stream is in");
  for (const StreamState state : kStreamStates) text.sample(state == status.state, {{"state", name(state)}});
  text.gauge("truepose_stream_armed", "Whether the stream is armed", armed);
  text.gauge("truepose_stream_gain", "How much of the correction is ramped in, 0 to 1", status.gain);
  if (status.heard)
    text.gauge("truepose_stream_packet_age_seconds", "Since the controller's last good datagram",
               std::chrono::duration<double>(now - *status.heard).count());
  text.gauge("truepose_stream_largest_step_degrees", "Greatest change of an axis from cycle to cycle",
             status.max_step_deg);
  text.family("truepose_stream_correction_degrees", "gauge", "Correction of each axis, sent last");
  for (std::size_t axis = 0; axis < status.correction_deg.size(); ++axis)
    text.sample(status.correction_deg[axis], {{"axis", std::to_string(axis + 1)}});
  write_stream_counters(text, status.counters);
  text.histogram("truepose_stream_turnaround_seconds", "From a datagram to its reply, in the kernel",
                 stream.turnaround_times(), kEdges_us);
  text.histogram("truepose_stream_compute_seconds", "Of this, from the datagram in hand to the reply",
                 stream.compute_times(), kEdges_us);
}

void write_clients(MetricsText& text, const DaemonMeasures& measures) {
  text.gauge("truepose_control_sessions", "Open sessions of the control protocol",
             static_cast<double>(measures.control.sessions));
  text.gauge("truepose_control_connections", "Connections of the control protocol, open sessions or not",
             static_cast<double>(measures.control.connections));
  text.gauge("truepose_web_connections", "Connections over HTTP",
             static_cast<double>(measures.web_connections));
  text.counter("truepose_control_requests_total", "Requests of the control protocol",
               static_cast<double>(measures.control.requests));
  text.gauge("truepose_events_next", "Number of the event that comes next; rises with each",
             static_cast<double>(measures.events));
  text.family("truepose_events_dropped_total", "counter", "Events that clients read too slowly for");
  for (const auto& [topic_name, topic] : control::kTopics) {
    const auto dropped = measures.control.dropped_events.find(topic);
    const bool none = dropped == measures.control.dropped_events.end();
    text.sample(none ? 0 : static_cast<double>(dropped->second), {{"topic", topic_name}});
  }
}

void write_store(MetricsText& text, const DaemonMeasures& measures) {
  text.gauge("truepose_store_bytes", "Of the store's files", static_cast<double>(measures.store_bytes));
  text.counter("truepose_store_jobs_total", "Jobs that the store's thread has done",
               static_cast<double>(measures.store_jobs));
  text.gauge("truepose_store_waiting", "Jobs of the store's thread that wait or are under way",
             static_cast<double>(measures.store_waiting));
}

}  // namespace

std::string metrics_text(const DaemonMeasures& measures) {
  MetricsText text;
  write_process(text, measures);
  write_cell(text, measures.snapshot);
  write_campaign(text, measures.snapshot.campaign);
  write_stream(text, measures.stream, measures.now, measures.snapshot.armed);
  write_clients(text, measures);
  write_store(text, measures);
  return text.text();
}

}  // namespace truepose::daemon
