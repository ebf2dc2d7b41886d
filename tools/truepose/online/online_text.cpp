#include "tools/truepose/online/online_text.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <map>

#include "core/formatted.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/events.hpp"
#include "tools/truepose/frame_text.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

constexpr double kHardly = 1e-6;  // of a probability: beyond, the digits say nothing

/// ": why", or nothing.
std::string because(const std::string& why) { return why.empty() ? "" : ": " + why; }

/// @param status  of the robot or the tracker
std::string device(const auto& status) {
  const std::string& reason = status.why_not_ready;
  if (!status.connected) return "not connected" + because(reason == "not connected" ? "" : reason);
  const std::string line = shown(status.model) + ", serial " + shown(status.serial);
  return reason.empty() ? line : line + ", not ready: " + reason;
}

std::string model_line(const rpc::ModelSummary& model) {
  return model.id + ", " + shown(model.validation_after_mm, 3, " mm") + " on validation poses" +
         (model.warning ? "; " + *model.warning : "");
}

std::string stream_line(const rpc::StreamStatus& stream) { return stream.state + because(stream.reason); }

/// What the controller says of itself: "-" where that is not known.
std::string condition_line(const rpc::StreamStatus::Robot& robot) {
  const auto flag = [](std::optional<bool> is_set, const char* yes, const char* no) {
    return !is_set ? "-" : *is_set ? yes : no;
  };
  const std::string line = "mode " + shown(robot.mode) + ", override " +
                           shown(robot.override_percent, 0, " %") + ", program " + shown(robot.program) +
                           ", emergency stop " + flag(robot.emergency_stop, "pressed", "not pressed") +
                           ", safety gate " + flag(robot.gate_open, "open", "closed");
  return robot.unknown.empty() ? line : line + " (not known: " + robot.unknown + ")";
}

/// What the tracker loop came to at each target.
std::string targets_table(const rpc::TargetsDocument& document) {
  std::vector<Cells> rows{{"TARGET", "REACHED", "ROUNDS", "FIRST mm", "LAST mm", "MEAN mm", ""}};
  for (const auto& target : document.targets) {
    const std::vector<double>& mm = target.errors_mm;
    const bool is_measured = !mm.empty();
    rows.push_back({shown(target.target), shown(target.reached), shown(mm.size()),
                    is_measured ? shown(mm.front(), 3) : "-", is_measured ? shown(mm.back(), 3) : "-",
                    is_measured ? shown(target.averaged_mm, 4) : "-",
                    target.reached ? "" : shown(target.reason)});
  }
  return text_table(rows);
}

/// Accuracy and repeatability of each pose of an ISO 9283 test, and how they vary with the direction of
/// approach.
std::string cycles_table(const rpc::Iso9283Document& document) {
  std::vector<Cells> rows{{"POSE", "CYCLES", "AP mm", "RP mm"}};
  for (const auto& set : document.test.sets)
    rows.push_back({set.point + (set.direction.empty() ? "" : " " + set.direction), shown(set.cycles),
                    shown(set.characteristics.accuracy.p_mm, 3),
                    shown(set.characteristics.repeatability.l_mm, 3)});
  std::string variations;
  for (const auto& of : document.test.variations)
    variations += of.point + ": vAP " + shown(of.variation.p_mm, 3) + " mm\n";
  const bool fitted = document.test.frame == record::Iso9283Frame::Fitted;
  return text_table(rows) + variations + "ISO 9283:1998, " +
         (document.compensated ? "compensated" : "not compensated") +
         (fitted ? ", AP after a fit of the frame\n" : "\n");
}

/// Of a document as the daemon has stored it; empty for a campaign of another kind.
template <class Document>
std::string stored_table(const json::value& stored, std::string (*table)(const Document&)) {
  if (stored.is_null()) return {};
  const auto document = record::from_json<Document>(stored);
  return "\n" + (document ? table(*document) : "the daemon's document: " + document.error() + "\n");
}

/// "0.012 -0.300 - 0 0 0 deg", "-" for what is not known.
std::string axes_text(const std::vector<std::optional<double>>& axes_deg) {
  if (axes_deg.empty()) return "-";
  std::string line;
  for (const auto& axis_deg : axes_deg) line += shown(axis_deg, 3) + " ";
  return line + "deg";
}

std::string kilobytes(std::uint64_t bytes) { return shown(static_cast<double>(bytes) / 1e3, 0); }

std::string measured_text(const std::vector<std::optional<double>>& axes_deg) {
  const bool is_known = std::ranges::any_of(axes_deg, [](const auto& axis) { return axis.has_value(); });
  if (!axes_deg.empty() && !is_known)
    return "not separated from the drives' lag yet: the arm moves evenly, or is watched for less than 2 s";
  return axes_text(axes_deg);
}

std::string tool_line(const rpc::StreamStatus::Tool& tool) {
  return shown(tool.number) +
         (tool.measured ? ", measured: its TCP is corrected" : ", not measured: the reflector is corrected");
}

// ---- Of events ----

std::string state_line(const rpc::StateChanged& x) {
  return shown(x.from) + " -> " + x.state + ": " + shown(x.reason);
}

std::string measured_line(const rpc::PointMeasured& x) {
  const std::string point = x.purpose + " pose " + shown(x.pose) + ": ";
  if (x.p_mm) return point + "error " + shown(x.error_mm, 3, " mm");
  return point + (x.reason.empty() ? "touched " + x.smr : "skipped, " + x.reason);
}

std::string model_line(const rpc::ModelChanged& x) { return x.change + " " + x.model.id; }

std::string fault_line(const rpc::FaultChanged& x) {
  return (x.active ? "" : "gone: ") + shown(x.fault.code) + ": " + shown(x.fault.text);
}

std::string control_line(const rpc::ControlChanged& x) {
  return shown(x.by) + ": " + x.change + (x.method ? " " + *x.method + ", " + shown(x.result) : "") +
         (x.from ? " from " + *x.from : "");
}

std::string log_line(const rpc::LogLine& x) { return x.level + ": " + shown(x.text); }

template <class Record>
std::string data_line(const json::object& data, std::string (*line)(const Record&)) {
  const auto record = record::from_json<Record>(data);
  return record ? line(*record) : control::json_text(data);
}

}  // namespace

std::string progress_line(const rpc::CampaignProgress& progress) {
  std::string line = progress.phase;
  line.resize(std::max<std::size_t>(line.size(), 11), ' ');
  line += "  " + shown(progress.done) + "/" + shown(progress.total) + " poses";
  if (progress.skipped.value_or(0) != 0) line += ", " + shown(progress.skipped) + " skipped";
  if (progress.error_mm) line += "  error " + shown(progress.error_mm, 3, " mm");
  if (progress.eta_s) line += "  " + duration_text(*progress.eta_s) + " left";
  if (const std::string reason = progress.reason.value_or(""); !reason.empty()) line += "  " + reason;
  return line;
}

std::string event_line(const control::Event& event) {
  const json::object& data = event.data;
  const std::string line =
      std::to_string(event.seq) + "  " + shown_time(event.time) + "  " + event.topic + "  ";
  if (event.topic == "campaign") return line + data_line<rpc::CampaignProgress>(data, progress_line);
  if (event.topic == "cell") return line + data_line(data, state_line);
  if (event.topic == "measurement") return line + data_line(data, measured_line);
  if (event.topic == "stream") return line + data_line(data, stream_line);
  if (event.topic == "model") return line + data_line<rpc::ModelChanged>(data, model_line);
  if (event.topic == "fault") return line + data_line(data, fault_line);
  if (event.topic == "control") return line + data_line(data, control_line);
  if (event.topic == "log") return line + data_line(data, log_line);
  return line + control::json_text(data);
}

namespace {

/// What there is of it, and what to do about it.
std::string interrupted_line(const rpc::InterruptedCampaign& campaign) {
  return campaign.kind + ", " + shown(campaign.done) + "/" + shown(campaign.total) +
         " poses: " + shown(campaign.reason) + "; resume it: truepose campaign resume " + campaign.id +
         ", end it: truepose campaign abort " + campaign.id;
}

}  // namespace

std::string status_text(const rpc::CellStatus& status) {
  const rpc::StreamStatus& stream = status.stream;
  const auto& [seconds, bytes, dropped, last] = status.recording;
  std::vector<Cells> rows{
      {"cell", shown(status.cell)},
      {"state", status.state + ": " + shown(status.state_text)},
      {"next", shown(status.next)},
      {"robot", device(status.robot) + (stream.armed ? "; " + condition_line(stream.robot) : "")},
      {"tracker", device(status.tracker)},
      {"model", status.model ? model_line(*status.model) : "none active"},
      {"stream", stream_line(stream)},
      {"recording",
       "the last " + shown(seconds, 0, " s") + ", " + kilobytes(bytes) + " kB, dropped " + shown(dropped)}};
  if (status.campaign) rows.push_back({"campaign", progress_line(*status.campaign)});
  for (const auto& interrupted : status.interrupted)
    rows.push_back({"interrupted", interrupted_line(interrupted)});
  for (const auto& fault : status.faults)
    rows.push_back({fault.severity, shown(fault.code) + ": " + shown(fault.text) + " (since " +
                                        shown_time(fault.since) + ")"});
  return text_table(rows);
}

std::string campaigns_text(const rpc::CampaignList::Result& list) {
  std::vector<Cells> rows{{"CAMPAIGN", "KIND", "STARTED", "STATE", "ROBOT", "MODEL"}};
  std::vector<std::string> ids, models;
  for (const auto& campaign : list.campaigns) {
    ids.push_back(campaign.id);
    models.push_back(campaign.model_id.value_or(""));
  }
  ids = shown_ids(std::move(ids));
  models = shown_ids(std::move(models));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const rpc::CampaignSummary& campaign = list.campaigns[i];
    rows.push_back({ids[i], campaign.kind, shown_time(campaign.started), campaign.state,
                    shown(campaign.robot_serial), shown(models[i])});
  }
  return rows.size() == 1 ? "no campaigns yet\n" : text_table(rows);
}

std::string campaign_text(const rpc::CampaignGet::Result& found) {
  const rpc::CampaignSummary& campaign = found.campaign;
  std::vector<Cells> rows{
      {"campaign", campaign.id},
      {"kind", campaign.kind},
      {"state", campaign.state},
      {"started", shown_time(campaign.started)},
      {"ended", shown_time(campaign.ended.value_or(""))},
      {"robot", shown(campaign.robot_model) + ", serial " + shown(campaign.robot_serial)},
      {"tracker", shown(campaign.tracker_model) + ", serial " + shown(campaign.tracker_serial)},
      {"model", shown(campaign.model_id)},
      {"points", shown(found.points_total)}};
  for (const auto& [name, text] : {std::pair{"started by", campaign.by.value_or("")},
                                   {"note", campaign.note},
                                   {"reason", campaign.reason}}) {
    if (!text.empty()) rows.push_back({name, text});
  }
  if (found.progress) rows.push_back({"progress", progress_line(*found.progress)});
  for (const auto& once : found.interruptions)
    rows.push_back({"interrupted", shown_time(once.interrupted) + ", resumed " + shown_time(once.resumed) +
                                       ": " + shown(once.found)});
  for (const auto& skipped : found.skipped)
    rows.push_back({"skipped", "pose " + shown(skipped.pose) + " after " + shown(skipped.attempts) +
                                   " attempts: " + shown(skipped.reason)});
  return text_table(rows) + stored_table(found.targets, targets_table) +
         stored_table(found.iso9283, cycles_table) + stored_table(found.frame, frame_text);
}

std::string tools_text(const rpc::ToolList::Result& list) {
  std::vector<Cells> rows{{"TOOL", "MEASURED", "BY", "KRL LINE"}};
  for (const auto& tool : list.tools)
    rows.push_back({shown(tool.number), shown(tool.measured),
                    tool.campaign_id ? "campaign " + *tool.campaign_id : "the cell file",
                    tool.refused ? "refused: " + *tool.refused : shown(tool.krl)});
  return rows.size() == 1 ? "no tool was measured and taken into use\n" : text_table(rows);
}

std::string models_text(const rpc::ModelList::Result& list) {
  std::vector<Cells> rows{{"MODEL", "CREATED", "ROBOT", "BEFORE mm", "AFTER mm", "ACTIVE"}};
  std::vector<std::string> ids;
  for (const auto& model : list.models) ids.push_back(model.id);
  ids = shown_ids(std::move(ids));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const rpc::ModelSummary& model = list.models[i];
    rows.push_back({ids[i], shown_time(model.created), shown(model.robot_serial),
                    shown(model.validation_before_mm, 3), shown(model.validation_after_mm, 3),
                    model.active ? "active" : ""});
  }
  return rows.size() == 1 ? "no models yet\n" : text_table(rows);
}

std::string model_text(const rpc::ModelGet::Result& found) {
  const auto& [model, parameters] = found;
  std::vector<Cells> rows{{"PARAMETER", "NOMINAL", "VALUE", "SIGMA"}};
  for (const auto& parameter : parameters)
    rows.push_back({parameter.name, shown(parameter.nominal, 6), shown(parameter.value, 6),
                    parameter.identified ? shown(parameter.sigma, 6) : "kept at nominal"});
  return text_table({{"model", model_line(model)},
                     {"created", shown_time(model.created)},
                     {"robot", shown(model.robot_serial)},
                     {"active", shown(model.active)}}) +
         "\n" + text_table(rows) + "lengths in mm, angles in rad\n";
}

namespace {

std::string percentiles_text(const rpc::Percentiles& us) {
  return "p50 " + shown(us.p50, 0) + ", p99 " + shown(us.p99, 0) + ", p99.9 " + shown(us.p999, 0) + ", max " +
         shown(us.max, 0, " us");
}

/// "SCHED_FIFO 80 on CPU 0 1 2 3, 71234 kB locked"
std::string scheduling_text(const std::optional<rpc::StreamScheduling>& thread) {
  if (!thread) return "-";
  std::string line = thread->policy + ' ' + shown(thread->priority) + " on CPU";
  for (const int cpu : thread->cpus) line += ' ' + shown(cpu);
  return line + ", " + shown(thread->locked_kB) + " kB locked";
}

}  // namespace

std::string recordings_text(const rpc::RecordingList::Result& list) {
  std::vector<Cells> rows{{"RECORDING", "KB", "REASON"}};
  for (const auto& recording : list.recordings)
    rows.push_back({recording.name, kilobytes(recording.bytes), shown(recording.reason)});
  return rows.size() == 1 ? "no recordings yet\n" : text_table(rows);
}

std::string acknowledged_text(const rpc::AuditAcknowledge::Result& answer) {
  return "acknowledged: " + shown(answer.acknowledged) + "\n";
}

std::string control_text(const rpc::Control& control) {
  if (!control.holder) return "no client has control: commands of every role are carried out\n";
  const std::string role{control.role ? control::name(*control.role) : "-"};
  const std::string left = control.left_s ? std::to_string(control.left_s->count()) : "-";
  return *control.holder + " (" + role + ") has control, for " + left + " s more unless it is renewed\n";
}

std::string audit_text(const rpc::AuditList::Result& list) {
  std::vector<Cells> rows{{"N", "TIME", "WHO", "ROLE", "FROM", "METHOD", "RESULT"}};
  std::map<std::uint64_t, std::string> results;
  for (const rpc::AuditRecord& record : list.records) {
    if (record.of) {
      results[*record.of] = shown(record.result) + (record.message ? ": " + shown(record.message) : "");
      continue;
    }
    const auto result = results.find(record.n);
    rows.push_back({shown(record.n), shown_time(record.time), shown(record.who), shown(record.role),
                    shown(record.from), shown(record.method),
                    result == results.end() ? shown(record.put_aside) : result->second});
  }
  return rows.size() == 1 ? "no commands yet\n" : text_table(rows);
}

std::string stream_text(const rpc::StreamStatus& stream) {
  std::vector<Cells> rows{{"state", stream_line(stream)}, {"model", shown(stream.model_id)}};
  if (!stream.arm.why_not.empty()) rows.push_back({"arm", stream.arm.why_not});
  const auto& [daemon, machine, network] = stream.late_by;
  const std::vector<Cells> always{
      {"tool", tool_line(stream.tool)},
      {"robot", condition_line(stream.robot)},
      {"controller", shown(stream.peer) + ", IPOC + " + shown(stream.ipoc_step) + ", session " +
                         shown(stream.sessions) + ", last packet " + shown(stream.packet_age_ms) + " ms ago"},
      {"cycles", shown(stream.cycles) + ", answered " + shown(stream.answered) + ", of these held " +
                     shown(stream.held) + ", repeated " + shown(stream.duplicate)},
      {"not answered", "unconfirmed " + shown(stream.unconfirmed) + ", wrong IPOC " +
                           shown(stream.wrong_ipoc) + ", malformed " + shown(stream.malformed) +
                           ", from others " + shown(stream.unexpected_sender)},
      {"trouble", "late " + shown(stream.late) + ", lost " + shown(stream.lost) + ", at a bound " +
                      shown(stream.clamped) + ", no solution " + shown(stream.no_solution)},
      {"refused last", shown(stream.refused)},
      {"correction", axes_text({stream.correction_deg.begin(), stream.correction_deg.end()})},
      {"measured", measured_text(stream.measured_deg)},
      {"largest step", shown(stream.max_step_deg, 5, " deg")},
      {"late by", "daemon " + shown(daemon) + ", machine " + shown(machine) + ", network " + shown(network)},
      {"wire", percentiles_text(stream.turnaround_us)},
      {"compute", percentiles_text(stream.compute_us)},
      {"scheduling", scheduling_text(stream.scheduling)}};
  rows.insert(rows.end(), always.begin(), always.end());
  return text_table(rows);
}

namespace {

std::string update_text(const record::ModelUpdate& update) {
  std::string text = update.offered ? "updated:\n" : "not updated:\n";
  for (const auto* sentences : {&update.moved, &update.rejected, &update.warnings})
    for (const std::string& sentence : *sentences) text += "  " + sentence + "\n";
  if (!update.offered) return text;
  return text +
         formatted(
             "  the points are off by %.3f mm, before by %.3f mm; each predicted by the others alone by "
             "%.3f mm\n",
             update.after, update.before, update.leave_one_out);
}

}  // namespace

std::string drift_text(const record::DriftDocument& drift) {
  std::vector<Cells> rows;
  for (const auto& [row, error_mm, length_mm] : drift.points) {
    rows.push_back({std::to_string(row)});
    for (const double mm : {error_mm.x(), error_mm.y(), error_mm.z(), length_mm})
      rows.back().push_back(formatted("%.3f", mm));
  }
  const double chance = drift.p_value;
  return "  row         x         y         z     error   (mm, predicted less measured)\n" +
         text_table({{5}, {9, 1}, {9, 1}, {9, 1}, {9, 1}}, rows) +
         formatted("\nIn an unchanged cell such errors or greater have a probability %s %.2g.\n",
                   chance < kHardly ? "below" : "of", std::max(chance, kHardly)) +
         (drift.uncertain_parameters
              ? ""
              : "The model file does not say how well its parameters are known; they were taken as exact.\n") +
         shown_verdict(std::string{name_of(record::kDriftVerdicts, drift.verdict)}) + ": " + drift.reason +
         ".\n" + (drift.update ? update_text(*drift.update) : "");
}

}  // namespace truepose::tools
