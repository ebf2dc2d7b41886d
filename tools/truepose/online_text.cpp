#include "tools/truepose/online_text.hpp"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "proto/control/json_text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using Row = std::vector<std::string>;

const json::value* find(const json::value& value, std::string_view pointer) {
  boost::system::error_code missing;
  const json::value* found = value.find_pointer({pointer.data(), pointer.size()}, missing);
  return missing || found->is_null() ? nullptr : found;
}

std::string text(const json::value& value, std::string_view pointer) {
  const json::value* found = find(value, pointer);
  if (!found) return "-";
  if (found->is_string()) return found->get_string().empty() ? "-" : std::string{found->get_string()};
  if (found->is_bool()) return found->get_bool() ? "yes" : "no";
  return control::json_text(*found);
}

std::string fixed(const json::value& value, std::string_view pointer, int digits, const char* unit = "") {
  const json::value* found = find(value, pointer);
  if (!found || !found->is_number()) return "-";
  char printed[64];
  std::snprintf(printed, sizeof printed, "%.*f%s", digits, found->to_number<double>(), unit);
  return printed;
}

bool is_true(const json::value& value, std::string_view pointer) {
  const json::value* found = find(value, pointer);
  return found && found->is_bool() && found->get_bool();
}

const json::array& list(const json::value& value, std::string_view pointer) {
  static const json::array kNone;
  const json::value* found = find(value, pointer);
  return found && found->is_array() ? found->get_array() : kNone;
}

std::string duration(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  if (whole >= 3600) return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
  if (whole >= 60) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole) + " s";
}

/// Columns of equal width, two spaces apart.
std::string table(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths;
  for (const Row& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string out;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i)
      line += row[i] + std::string(widths[i] - row[i].size() + 2, ' ');
    out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

std::string device(const json::value& status, const std::string& pointer) {
  if (!is_true(status, pointer + "/connected")) return "not connected";
  std::string line = text(status, pointer + "/model") + ", serial " + text(status, pointer + "/serial");
  const std::string reason = text(status, pointer + "/why_not_ready");
  return reason == "-" ? line : line + ", not ready: " + reason;
}

/// @param at  where in the answer the model is
std::string model_line(const json::value& answer, const std::string& at) {
  return text(answer, at + "/id") + ", " + fixed(answer, at + "/validation_after_mm", 3, " mm") +
         " on validation poses";
}

std::string stream_line(const json::value& stream) {
  const std::string reason = text(stream, "/reason");
  return text(stream, "/state") + (reason == "-" ? "" : ": " + reason);
}

/// What the tracker loop came to at each target; empty for a campaign of another kind.
std::string targets_table(const json::value& campaign) {
  if (!find(campaign, "/targets")) return {};
  std::vector<Row> rows{{"TARGET", "REACHED", "ROUNDS", "FIRST mm", "LAST mm", "MEAN mm", ""}};
  for (const json::value& target : list(campaign, "/targets/targets")) {
    const std::size_t rounds = list(target, "/errors_mm").size();
    const std::string last = "/errors_mm/" + std::to_string(rounds - 1);
    rows.push_back({text(target, "/target"), text(target, "/reached"), std::to_string(rounds),
                    fixed(target, "/errors_mm/0", 3), rounds == 0 ? "-" : fixed(target, last, 3),
                    rounds == 0 ? "-" : fixed(target, "/averaged_mm", 4),
                    is_true(target, "/reached") ? "" : text(target, "/reason")});
  }
  return "\n" + table(rows);
}

/// Accuracy and repeatability of each pose of an ISO 9283 test, and how they vary with the direction of
/// approach; empty for a campaign of another kind.
std::string cycles_table(const json::value& campaign) {
  if (!find(campaign, "/iso9283")) return {};
  std::vector<Row> rows{{"POSE", "CYCLES", "AP mm", "RP mm"}};
  for (const json::value& set : list(campaign, "/iso9283/sets")) {
    std::string pose = text(set, "/point");
    if (!set.at("direction").as_string().empty()) pose += " " + text(set, "/direction");
    rows.push_back({pose, text(set, "/cycles"), fixed(set, "/AP/p", 3), fixed(set, "/RP/l", 3)});
  }
  std::string variations;
  for (const json::value& variation : list(campaign, "/iso9283/variations"))
    variations += text(variation, "/point") + ": vAP " + fixed(variation, "/vAP/p", 3) + " mm\n";
  return "\n" + table(rows) + variations + "ISO 9283:1998, " +
         (is_true(campaign, "/iso9283/compensated") ? "compensated" : "not compensated") +
         (text(campaign, "/iso9283/frame") == "fitted" ? ", AP after a fit of the frame\n" : "\n");
}

}  // namespace

std::string progress_line(const json::value& progress) {
  std::string line = text(progress, "/phase");
  line.resize(std::max<std::size_t>(line.size(), 11), ' ');
  line += "  " + text(progress, "/done") + "/" + text(progress, "/total") + " poses";
  if (find(progress, "/error_mm")) line += "  error " + fixed(progress, "/error_mm", 3, " mm");
  if (const json::value* left = find(progress, "/eta_s"); left && left->is_number())
    line += "  " + duration(left->to_number<double>()) + " left";
  if (const std::string reason = text(progress, "/reason"); reason != "-") line += "  " + reason;
  return line;
}

std::string event_line(const control::Event& event) {
  const json::value data = event.data;
  std::string line = std::to_string(event.seq) + "  " + event.time + "  " + event.topic + "  ";
  if (event.topic == "campaign") return line + progress_line(data);
  if (event.topic == "cell")
    return line + text(data, "/from") + " -> " + text(data, "/state") + ": " + text(data, "/reason");
  if (event.topic == "measurement")
    return line + text(data, "/purpose") + " pose " + text(data, "/pose") + ": " +
           (find(data, "/p_mm") ? "error " + fixed(data, "/error_mm", 3, " mm")
                                : "skipped, " + text(data, "/reason"));
  if (event.topic == "stream") return line + stream_line(data);
  if (event.topic == "model") return line + text(data, "/change") + " " + text(data, "/model/id");
  if (event.topic == "fault")
    return line + (is_true(data, "/standing") ? "" : "gone: ") + text(data, "/code") + ": " +
           text(data, "/text");
  if (event.topic == "log") return line + text(data, "/level") + ": " + text(data, "/text");
  return line + control::json_text(data);
}

std::string status_text(const json::value& status) {
  std::vector<Row> rows{{"cell", text(status, "/cell")},
                        {"state", text(status, "/state") + ": " + text(status, "/state_text")},
                        {"robot", device(status, "/robot")},
                        {"tracker", device(status, "/tracker")},
                        {"model", "none active"},
                        {"stream", "-"}};
  if (find(status, "/model")) rows[4][1] = model_line(status, "/model");
  if (const json::value* stream = find(status, "/stream")) rows[5][1] = stream_line(*stream);
  if (const json::value* campaign = find(status, "/campaign"))
    rows.push_back({"campaign", progress_line(*campaign)});
  for (const json::value& fault : list(status, "/faults"))
    rows.push_back({text(fault, "/severity"), text(fault, "/code") + ": " + text(fault, "/text") +
                                                  " (since " + text(fault, "/since") + ")"});
  return table(rows);
}

std::string campaigns_text(const json::value& answer) {
  std::vector<Row> rows{{"CAMPAIGN", "KIND", "STARTED", "STATE", "ROBOT", "MODEL"}};
  for (const json::value& campaign : list(answer, "/campaigns"))
    rows.push_back({text(campaign, "/id"), text(campaign, "/kind"), text(campaign, "/started"),
                    text(campaign, "/state"), text(campaign, "/robot_serial"), text(campaign, "/model_id")});
  return rows.size() == 1 ? "no campaigns yet\n" : table(rows);
}

std::string campaign_text(const json::value& answer) {
  std::vector<Row> rows{
      {"campaign", text(answer, "/campaign/id")},
      {"kind", text(answer, "/campaign/kind")},
      {"state", text(answer, "/campaign/state")},
      {"started", text(answer, "/campaign/started")},
      {"ended", text(answer, "/campaign/ended")},
      {"robot", text(answer, "/campaign/robot_model") + ", serial " + text(answer, "/campaign/robot_serial")},
      {"tracker",
       text(answer, "/campaign/tracker_model") + ", serial " + text(answer, "/campaign/tracker_serial")},
      {"model", text(answer, "/campaign/model_id")},
      {"points", text(answer, "/points_total")}};
  if (const std::string reason = text(answer, "/campaign/reason"); reason != "-")
    rows.push_back({"reason", reason});
  if (const json::value* progress = find(answer, "/progress"))
    rows.push_back({"progress", progress_line(*progress)});
  for (const json::value& skipped : list(answer, "/skipped"))
    rows.push_back({"skipped", "pose " + text(skipped, "/pose") + " after " + text(skipped, "/attempts") +
                                   " attempts: " + text(skipped, "/reason")});
  return table(rows) + targets_table(answer) + cycles_table(answer);
}

std::string models_text(const json::value& answer) {
  std::vector<Row> rows{{"MODEL", "CREATED", "ROBOT", "BEFORE mm", "AFTER mm", "ACTIVE"}};
  for (const json::value& model : list(answer, "/models"))
    rows.push_back({text(model, "/id"), text(model, "/created"), text(model, "/robot_serial"),
                    fixed(model, "/validation_before_mm", 3), fixed(model, "/validation_after_mm", 3),
                    is_true(model, "/active") ? "active" : ""});
  return rows.size() == 1 ? "no models yet\n" : table(rows);
}

std::string model_text(const json::value& answer) {
  std::vector<Row> rows{{"PARAMETER", "NOMINAL", "VALUE", "SIGMA"}};
  for (const json::value& parameter : list(answer, "/parameters"))
    rows.push_back({text(parameter, "/name"), fixed(parameter, "/nominal", 6), fixed(parameter, "/value", 6),
                    is_true(parameter, "/identified") ? fixed(parameter, "/sigma", 6) : "kept at nominal"});
  return table({{"model", model_line(answer, "/model")},
                {"created", text(answer, "/model/created")},
                {"robot", text(answer, "/model/robot_serial")},
                {"active", text(answer, "/model/active")}}) +
         "\n" + table(rows) + "lengths in mm, angles in rad\n";
}

/// "0.012 -0.300 - 0 0 0 deg", "-" for what is not known.
std::string axes_text(const json::value& document, std::string_view path) {
  const json::value* const axes = find(document, path);
  if (!axes || !axes->is_array() || axes->as_array().empty()) return "-";
  std::string line;
  for (const json::value& axis : axes->as_array()) {
    std::array<char, 32> number{"-"};
    if (axis.is_number()) std::snprintf(number.data(), number.size(), "%.3f", axis.to_number<double>());
    line += std::string{number.data()} + " ";
  }
  return line + "deg";
}

std::string measured_text(const json::value& stream) {
  const json::array& axes = list(stream, "/measured_deg");
  const bool unknown = std::ranges::all_of(axes, [](const json::value& axis) { return axis.is_null(); });
  if (!axes.empty() && unknown)
    return "not told from the drives' lag yet: the arm moves evenly, or is watched for less than 2 s";
  return axes_text(stream, "/measured_deg");
}

std::string stream_text(const json::value& stream) {
  return table(
      {{"state", stream_line(stream)},
       {"model", text(stream, "/model_id")},
       {"controller", text(stream, "/peer") + ", IPOC + " + text(stream, "/ipoc_step") + ", session " +
                          text(stream, "/sessions") + ", last packet " + text(stream, "/packet_age_ms") +
                          " ms ago"},
       {"cycles", text(stream, "/cycles") + ", answered " + text(stream, "/answered") + ", of these held " +
                      text(stream, "/held") + ", repeated " + text(stream, "/duplicate")},
       {"not answered", "unproven " + text(stream, "/unproven") + ", wrong IPOC " +
                            text(stream, "/wrong_ipoc") + ", malformed " + text(stream, "/malformed") +
                            ", from others " + text(stream, "/foreign")},
       {"trouble", "late " + text(stream, "/late") + ", lost " + text(stream, "/lost") + ", at a bound " +
                       text(stream, "/clamped") + ", no solution " + text(stream, "/no_solution")},
       {"refused last", text(stream, "/refused")},
       {"correction", axes_text(stream, "/correction_deg")},
       {"measured", measured_text(stream)},
       {"largest step", fixed(stream, "/max_step_deg", 5, " deg")},
       {"turnaround", "p50 " + fixed(stream, "/turnaround_us/p50", 0) + ", p99 " +
                          fixed(stream, "/turnaround_us/p99", 0) + ", p99.9 " +
                          fixed(stream, "/turnaround_us/p999", 0) + ", max " +
                          fixed(stream, "/turnaround_us/max", 0, " us")}});
}

}  // namespace truepose::tools
