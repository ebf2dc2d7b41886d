#include "tools/truepose/online/online_text.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <cmath>
#include <map>

#include "core/formatted.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/frame_text.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

constexpr double kHardly = 1e-6;  // of a probability: beyond, the digits say nothing

std::string duration(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  if (whole >= 3600) return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
  if (whole >= 60) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole) + " s";
}

std::string device(const json::value& status, const std::string& pointer) {
  const std::string reason = text_at(status, pointer + "/why_not_ready");
  if (!is_true_at(status, pointer + "/connected"))
    return reason == "-" || reason == "not connected" ? "not connected" : "not connected: " + reason;
  std::string line = text_at(status, pointer + "/model") + ", serial " + text_at(status, pointer + "/serial");
  return reason == "-" ? line : line + ", not ready: " + reason;
}

/// @param at  where in the answer the model is
std::string model_line(const json::value& answer, const std::string& at) {
  return text_at(answer, at + "/id") + ", " + number_at(answer, at + "/validation_after_mm", 3, " mm") +
         " on validation poses";
}

std::string stream_line(const json::value& stream) {
  const std::string reason = text_at(stream, "/reason");
  return text_at(stream, "/state") + (reason == "-" ? "" : ": " + reason);
}

/// What the controller tells of itself: "-" where that is not known.
std::string condition_line(const json::value& stream) {
  const auto flag = [&](const char* at, const char* yes, const char* no) {
    return !find_at(stream, at) ? "-" : is_true_at(stream, at) ? yes : no;
  };
  std::string line = "mode " + text_at(stream, "/robot/mode") + ", override " +
                     number_at(stream, "/robot/override_percent", 0, " %") + ", program " +
                     text_at(stream, "/robot/program") + ", emergency stop " +
                     flag("/robot/emergency_stop", "pressed", "not pressed") + ", safety gate " +
                     flag("/robot/gate_open", "open", "closed");
  const std::string why = text_at(stream, "/robot/unknown");
  return why == "-" ? line : line + " (not known: " + why + ")";
}

/// What the tracker loop came to at each target; empty for a campaign of another kind.
std::string targets_table(const json::value& campaign) {
  if (!find_at(campaign, "/targets")) return {};
  std::vector<Cells> rows{{"TARGET", "REACHED", "ROUNDS", "FIRST mm", "LAST mm", "MEAN mm", ""}};
  for (const json::value& target : list_at(campaign, "/targets/targets")) {
    const std::size_t rounds = list_at(target, "/errors_mm").size();
    const std::string last = "/errors_mm/" + std::to_string(rounds - 1);
    rows.push_back({text_at(target, "/target"), text_at(target, "/reached"), std::to_string(rounds),
                    number_at(target, "/errors_mm/0", 3), rounds == 0 ? "-" : number_at(target, last, 3),
                    rounds == 0 ? "-" : number_at(target, "/averaged_mm", 4),
                    is_true_at(target, "/reached") ? "" : text_at(target, "/reason")});
  }
  return "\n" + text_table(rows);
}

/// Accuracy and repeatability of each pose of an ISO 9283 test, and how they vary with the direction of
/// approach; empty for a campaign of another kind.
std::string cycles_table(const json::value& campaign) {
  if (!find_at(campaign, "/iso9283")) return {};
  std::vector<Cells> rows{{"POSE", "CYCLES", "AP mm", "RP mm"}};
  for (const json::value& set : list_at(campaign, "/iso9283/sets")) {
    std::string pose = text_at(set, "/point");
    if (!set.at("direction").as_string().empty()) pose += " " + text_at(set, "/direction");
    rows.push_back({pose, text_at(set, "/cycles"), number_at(set, "/AP/p", 3), number_at(set, "/RP/l", 3)});
  }
  std::string variations;
  for (const json::value& variation : list_at(campaign, "/iso9283/variations"))
    variations += text_at(variation, "/point") + ": vAP " + number_at(variation, "/vAP/p", 3) + " mm\n";
  return "\n" + text_table(rows) + variations + "ISO 9283:1998, " +
         (is_true_at(campaign, "/iso9283/compensated") ? "compensated" : "not compensated") +
         (text_at(campaign, "/iso9283/frame") == "fitted" ? ", AP after a fit of the frame\n" : "\n");
}

std::string frame_table(const json::value& campaign) {
  const json::value* const found = find_at(campaign, "/frame");
  if (!found) return {};
  const auto document = record::read_frame_document(*found);
  return "\n" + (document ? frame_text(*document) : "the daemon's document: " + document.error() + "\n");
}

/// "0.012 -0.300 - 0 0 0 deg", "-" for what is not known.
std::string axes_text(const json::value& document, std::string_view path) {
  const json::value* const axes = find_at(document, path);
  if (!axes || !axes->is_array() || axes->as_array().empty()) return "-";
  std::string line;
  for (const json::value& axis : axes->as_array()) {
    line += axis.is_number() ? formatted("%.3f ", axis.to_number<double>()) : "- ";
  }
  return line + "deg";
}

std::string kilobytes_at(const json::value& document, std::string_view path) {
  const json::value* const bytes = find_at(document, path);
  return bytes && bytes->is_number() ? formatted("%.0f", bytes->to_number<double>() / 1e3) : "-";
}

std::string measured_text(const json::value& stream) {
  const json::array& axes = list_at(stream, "/measured_deg");
  const bool unknown = std::ranges::all_of(axes, [](const json::value& axis) { return axis.is_null(); });
  if (!axes.empty() && unknown)
    return "not separated from the drives' lag yet: the arm moves evenly, or is watched for less than 2 s";
  return axes_text(stream, "/measured_deg");
}

std::string tool_line(const json::value& stream) {
  const bool is_measured = is_true_at(stream, "/tool/measured");
  return text_at(stream, "/tool/number") +
         (is_measured ? ", measured: its TCP is corrected" : ", not measured: the reflector is corrected");
}

}  // namespace

std::string progress_line(const json::value& progress) {
  std::string line = text_at(progress, "/phase");
  line.resize(std::max<std::size_t>(line.size(), 11), ' ');
  line += "  " + text_at(progress, "/done") + "/" + text_at(progress, "/total") + " poses";
  if (const json::value* skipped = find_at(progress, "/skipped"); skipped && *skipped != 0)
    line += ", " + text_at(progress, "/skipped") + " skipped";
  if (find_at(progress, "/error_mm")) line += "  error " + number_at(progress, "/error_mm", 3, " mm");
  if (const json::value* left = find_at(progress, "/eta_s"); left && left->is_number())
    line += "  " + duration(left->to_number<double>()) + " left";
  if (const std::string reason = text_at(progress, "/reason"); reason != "-") line += "  " + reason;
  return line;
}

std::string event_line(const control::Event& event) {
  const json::value data = event.data;
  std::string line = std::to_string(event.seq) + "  " + event.time + "  " + event.topic + "  ";
  if (event.topic == "campaign") return line + progress_line(data);
  if (event.topic == "cell")
    return line + text_at(data, "/from") + " -> " + text_at(data, "/state") + ": " + text_at(data, "/reason");
  if (event.topic == "measurement")
    return line + text_at(data, "/purpose") + " pose " + text_at(data, "/pose") + ": " +
           (find_at(data, "/p_mm")               ? "error " + number_at(data, "/error_mm", 3, " mm")
            : string_at(data, "/reason").empty() ? "touched " + string_at(data, "/smr")
                                                 : "skipped, " + text_at(data, "/reason"));
  if (event.topic == "stream") return line + stream_line(data);
  if (event.topic == "model") return line + text_at(data, "/change") + " " + text_at(data, "/model/id");
  if (event.topic == "fault")
    return line + (is_true_at(data, "/active") ? "" : "gone: ") + text_at(data, "/code") + ": " +
           text_at(data, "/text");
  if (event.topic == "control")
    return line + text_at(data, "/by") + ": " + text_at(data, "/change") +
           (find_at(data, "/method") ? " " + text_at(data, "/method") + ", " + text_at(data, "/result")
                                     : "") +
           (find_at(data, "/from") ? " from " + text_at(data, "/from") : "");
  if (event.topic == "log") return line + text_at(data, "/level") + ": " + text_at(data, "/text");
  return line + control::json_text(data);
}

namespace {

/// What there is of it, and what to do about it.
std::string interrupted_line(const json::value& campaign) {
  const std::string id = text_at(campaign, "/id");
  return text_at(campaign, "/kind") + ", " + text_at(campaign, "/done") + "/" + text_at(campaign, "/total") +
         " poses: " + text_at(campaign, "/reason") + "; resume it: truepose campaign resume " + id +
         ", end it: truepose campaign abort " + id;
}

}  // namespace

std::string status_text(const json::value& status) {
  std::vector<Cells> rows{{"cell", text_at(status, "/cell")},
                          {"state", text_at(status, "/state") + ": " + text_at(status, "/state_text")},
                          {"next", text_at(status, "/next")},
                          {"robot", device(status, "/robot")},
                          {"tracker", device(status, "/tracker")},
                          {"model", "none active"},
                          {"stream", "-"}};
  if (find_at(status, "/model")) rows[5][1] = model_line(status, "/model");
  if (const json::value* stream = find_at(status, "/stream")) rows[6][1] = stream_line(*stream);
  if (is_true_at(status, "/stream/armed")) rows[3][1] += "; " + condition_line(*find_at(status, "/stream"));
  if (find_at(status, "/recording"))
    rows.push_back({"recording", "the last " + number_at(status, "/recording/seconds", 0, " s") + ", " +
                                     kilobytes_at(status, "/recording/bytes") + " kB, dropped " +
                                     text_at(status, "/recording/dropped")});
  if (const json::value* campaign = find_at(status, "/campaign"))
    rows.push_back({"campaign", progress_line(*campaign)});
  for (const json::value& interrupted : list_at(status, "/interrupted"))
    rows.push_back({"interrupted", interrupted_line(interrupted)});
  for (const json::value& fault : list_at(status, "/faults"))
    rows.push_back({text_at(fault, "/severity"), text_at(fault, "/code") + ": " + text_at(fault, "/text") +
                                                     " (since " + text_at(fault, "/since") + ")"});
  return text_table(rows);
}

std::string campaigns_text(const json::value& answer) {
  std::vector<Cells> rows{{"CAMPAIGN", "KIND", "STARTED", "STATE", "ROBOT", "MODEL"}};
  for (const json::value& campaign : list_at(answer, "/campaigns"))
    rows.push_back({text_at(campaign, "/id"), text_at(campaign, "/kind"), text_at(campaign, "/started"),
                    text_at(campaign, "/state"), text_at(campaign, "/robot_serial"),
                    text_at(campaign, "/model_id")});
  return rows.size() == 1 ? "no campaigns yet\n" : text_table(rows);
}

std::string campaign_text(const json::value& answer) {
  std::vector<Cells> rows{{"campaign", text_at(answer, "/campaign/id")},
                          {"kind", text_at(answer, "/campaign/kind")},
                          {"state", text_at(answer, "/campaign/state")},
                          {"started", text_at(answer, "/campaign/started")},
                          {"ended", text_at(answer, "/campaign/ended")},
                          {"robot", text_at(answer, "/campaign/robot_model") + ", serial " +
                                        text_at(answer, "/campaign/robot_serial")},
                          {"tracker", text_at(answer, "/campaign/tracker_model") + ", serial " +
                                          text_at(answer, "/campaign/tracker_serial")},
                          {"model", text_at(answer, "/campaign/model_id")},
                          {"points", text_at(answer, "/points_total")}};
  for (const auto& [name, pointer] : {std::pair{"started by", "/campaign/by"},
                                      {"note", "/campaign/note"},
                                      {"reason", "/campaign/reason"}}) {
    const std::string text = text_at(answer, pointer);
    if (text != "-") rows.push_back({name, text});
  }
  if (const json::value* progress = find_at(answer, "/progress"))
    rows.push_back({"progress", progress_line(*progress)});
  for (const json::value& once : list_at(answer, "/interruptions"))
    rows.push_back({"interrupted", text_at(once, "/interrupted") + ", resumed " + text_at(once, "/resumed") +
                                       ": " + text_at(once, "/found")});
  for (const json::value& skipped : list_at(answer, "/skipped"))
    rows.push_back({"skipped", "pose " + text_at(skipped, "/pose") + " after " +
                                   text_at(skipped, "/attempts") +
                                   " attempts: " + text_at(skipped, "/reason")});
  return text_table(rows) + targets_table(answer) + cycles_table(answer) + frame_table(answer);
}

std::string tools_text(const json::value& answer) {
  std::vector<Cells> rows{{"TOOL", "MEASURED", "BY", "KRL LINE"}};
  for (const json::value& tool : list_at(answer, "/tools"))
    rows.push_back(
        {text_at(tool, "/number"), text_at(tool, "/measured"),
         find_at(tool, "/campaign_id") ? "campaign " + text_at(tool, "/campaign_id") : "the cell file",
         find_at(tool, "/refused") ? "refused: " + text_at(tool, "/refused") : text_at(tool, "/krl")});
  return rows.size() == 1 ? "no tool was measured and taken into use\n" : text_table(rows);
}

std::string models_text(const json::value& answer) {
  std::vector<Cells> rows{{"MODEL", "CREATED", "ROBOT", "BEFORE mm", "AFTER mm", "ACTIVE"}};
  for (const json::value& model : list_at(answer, "/models"))
    rows.push_back({text_at(model, "/id"), text_at(model, "/created"), text_at(model, "/robot_serial"),
                    number_at(model, "/validation_before_mm", 3), number_at(model, "/validation_after_mm", 3),
                    is_true_at(model, "/active") ? "active" : ""});
  return rows.size() == 1 ? "no models yet\n" : text_table(rows);
}

std::string model_text(const json::value& answer) {
  std::vector<Cells> rows{{"PARAMETER", "NOMINAL", "VALUE", "SIGMA"}};
  for (const json::value& parameter : list_at(answer, "/parameters"))
    rows.push_back(
        {text_at(parameter, "/name"), number_at(parameter, "/nominal", 6), number_at(parameter, "/value", 6),
         is_true_at(parameter, "/identified") ? number_at(parameter, "/sigma", 6) : "kept at nominal"});
  return text_table({{"model", model_line(answer, "/model")},
                     {"created", text_at(answer, "/model/created")},
                     {"robot", text_at(answer, "/model/robot_serial")},
                     {"active", text_at(answer, "/model/active")}}) +
         "\n" + text_table(rows) + "lengths in mm, angles in rad\n";
}

std::string percentiles_text(const json::value& stream, const std::string& where) {
  return "p50 " + number_at(stream, where + "/p50", 0) + ", p99 " + number_at(stream, where + "/p99", 0) +
         ", p99.9 " + number_at(stream, where + "/p999", 0) + ", max " +
         number_at(stream, where + "/max", 0, " us");
}

/// "SCHED_FIFO 80 on CPU 0 1 2 3, 71234 kB locked"
std::string scheduling_text(const json::value& stream) {
  std::string line = text_at(stream, "/scheduling/policy");
  if (line == "-") return line;
  line += ' ' + text_at(stream, "/scheduling/priority") + " on CPU";
  for (const json::value& cpu : list_at(stream, "/scheduling/cpus")) line += ' ' + text_at(cpu, "");
  return line + ", " + text_at(stream, "/scheduling/locked_kB") + " kB locked";
}

std::string recordings_text(const json::value& answer) {
  std::vector<Cells> rows{{"RECORDING", "KB", "REASON"}};
  for (const json::value& recording : list_at(answer, "/recordings"))
    rows.push_back(
        {text_at(recording, "/name"), kilobytes_at(recording, "/bytes"), text_at(recording, "/reason")});
  return rows.size() == 1 ? "no recordings yet\n" : text_table(rows);
}

std::string acknowledged_text(const json::value& answer) {
  return "acknowledged: " + text_at(answer, "/acknowledged") + "\n";
}

std::string control_text(const json::value& control) {
  if (!find_at(control, "/holder")) return "no client has control: commands of every role are carried out\n";
  return text_at(control, "/holder") + " (" + text_at(control, "/role") + ") has control, for " +
         text_at(control, "/left_s") + " s more unless it is renewed\n";
}

std::string audit_text(const json::value& answer) {
  std::vector<Cells> rows{{"N", "TIME", "WHO", "ROLE", "FROM", "METHOD", "RESULT"}};
  std::map<std::string, std::string> results;
  for (const json::value& record : list_at(answer, "/records")) {
    if (find_at(record, "/of")) {
      const std::string why = find_at(record, "/message") ? ": " + text_at(record, "/message") : "";
      results[text_at(record, "/of")] = text_at(record, "/result") + why;
      continue;
    }
    const std::string n = text_at(record, "/n");
    const auto result = results.find(n);
    const std::string otherwise = find_at(record, "/put_aside") ? text_at(record, "/put_aside") : "-";
    rows.push_back({n, text_at(record, "/time"), text_at(record, "/who"), text_at(record, "/role"),
                    text_at(record, "/from"), text_at(record, "/method"),
                    result == results.end() ? otherwise : result->second});
  }
  return rows.size() == 1 ? "no commands yet\n" : text_table(rows);
}

std::string stream_text(const json::value& stream) {
  std::vector<std::vector<std::string>> rows{{"state", stream_line(stream)},
                                             {"model", text_at(stream, "/model_id")}};
  if (const std::string why = text_at(stream, "/arm/why_not"); !why.empty() && why != "-")
    rows.push_back({"arm", why});
  const std::vector<std::vector<std::string>> always{
      {"tool", tool_line(stream)},
      {"robot", condition_line(stream)},
      {"controller", text_at(stream, "/peer") + ", IPOC + " + text_at(stream, "/ipoc_step") + ", session " +
                         text_at(stream, "/sessions") + ", last packet " + text_at(stream, "/packet_age_ms") +
                         " ms ago"},
      {"cycles", text_at(stream, "/cycles") + ", answered " + text_at(stream, "/answered") +
                     ", of these held " + text_at(stream, "/held") + ", repeated " +
                     text_at(stream, "/duplicate")},
      {"not answered", "unconfirmed " + text_at(stream, "/unconfirmed") + ", wrong IPOC " +
                           text_at(stream, "/wrong_ipoc") + ", malformed " + text_at(stream, "/malformed") +
                           ", from others " + text_at(stream, "/unexpected_sender")},
      {"trouble", "late " + text_at(stream, "/late") + ", lost " + text_at(stream, "/lost") +
                      ", at a bound " + text_at(stream, "/clamped") + ", no solution " +
                      text_at(stream, "/no_solution")},
      {"refused last", text_at(stream, "/refused")},
      {"correction", axes_text(stream, "/correction_deg")},
      {"measured", measured_text(stream)},
      {"largest step", number_at(stream, "/max_step_deg", 5, " deg")},
      {"late by", "daemon " + text_at(stream, "/late_by/daemon") + ", machine " +
                      text_at(stream, "/late_by/machine") + ", network " +
                      text_at(stream, "/late_by/network")},
      {"wire", percentiles_text(stream, "/turnaround_us")},
      {"compute", percentiles_text(stream, "/compute_us")},
      {"scheduling", scheduling_text(stream)}};
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
         std::string{name_of(record::kDriftVerdicts, drift.verdict)} + ": " + drift.reason + ".\n" +
         (drift.update ? update_text(*drift.update) : "");
}

}  // namespace truepose::tools
