#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstdio>
#include <memory>

#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "daemon/replay/replay.hpp"
#include "proto/control/json_text.hpp"
#include "proto/recording/recording.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using daemon::ReplayNote;
using daemon::ReplayReport;
using daemon::StreamReport;
using recording::Header;
using recording::Recording;

constexpr std::size_t kMostBytes = std::size_t{5} << 30;

struct Replay {
  std::string file;
  bool json = false;
};

/// Seconds before the recording was written.
std::string time_text(std::int64_t time_ns, const Header& header) {
  return formatted("%.6f", static_cast<double>(time_ns - header.time_ns) / 1e9);
}

// ---- As JSON ----

json::value note_json(const std::optional<ReplayNote>& note, const Header& header) {
  if (!note) return {};
  const double time_s = static_cast<double>(note->time_ns - header.time_ns) / 1e9;
  return json::object{{"time_s", time_s}, {"text", note->text}};
}

json::array notes_json(const std::vector<ReplayNote>& notes, const Header& header) {
  json::array all;
  for (const ReplayNote& note : notes) all.push_back(note_json(note, header));
  return all;
}

json::object device_json(const recording::Device& device) {
  return {{"model", device.model}, {"serial", device.serial}, {"software", device.software}};
}

json::object counters_json(const std::map<std::string, std::uint64_t>& counters) {
  json::object all;
  for (const auto& [name, count] : counters) all[name] = count;
  return all;
}

json::object stream_json(const StreamReport& stream, const Header& header) {
  return {{"datagrams", stream.datagrams},
          {"rejected", stream.rejected},
          {"first_rejected", note_json(stream.first_rejected, header)},
          {"sessions", stream.sessions},
          {"compared", stream.compared},
          {"different", stream.different},
          {"first_different", note_json(stream.first_different, header)},
          {"not_compared", json::array(stream.not_compared.begin(), stream.not_compared.end())},
          {"faults", notes_json(stream.faults, header)},
          {"counters", counters_json(stream.counters)},
          {"max_step_deg", stream.max_step_deg}};
}

json::object report_json(const Header& header, const ReplayReport& report) {
  json::array models;
  for (const recording::Model& model : header.models)
    models.push_back(json::object{{"id", model.id}, {"sha256", model.sha256}});
  return {{"product", header.product},
          {"cell", header.cell},
          {"date", header.date},
          {"reason", header.reason},
          {"robot", device_json(header.robot)},
          {"tracker", device_json(header.tracker)},
          {"models", std::move(models)},
          {"records", report.records},
          {"dropped", report.dropped},
          {"seconds", static_cast<double>(report.end_ns - report.begin_ns) / 1e9},
          {"damage", report.damage},
          {"stream", stream_json(report.stream, header)},
          {"recorded_faults", notes_json(report.recorded_faults, header)},
          {"same", report.same()}};
}

// ---- As text ----

std::string device_text(const recording::Device& device) {
  if (device.model.empty()) return "not connected";
  return device.model + ", serial " + device.serial + ", " + device.software;
}

std::string header_text(const Header& header, const ReplayReport& report) {
  std::string models;
  for (const recording::Model& model : header.models) models += (models.empty() ? "" : ", ") + model.id;
  return text_table(
      {{"cell", header.cell + ", truepose " + header.product},
       {"written", header.date + ": " + header.reason},
       {"robot", device_text(header.robot)},
       {"tracker", device_text(header.tracker)},
       {"models", models.empty() ? "none" : models},
       {"records", formatted("%llu in %.3f s, dropped %llu", static_cast<unsigned long long>(report.records),
                             static_cast<double>(report.end_ns - report.begin_ns) / 1e9,
                             static_cast<unsigned long long>(report.dropped))}});
}

std::string note_line(const std::string& what, const ReplayNote& note, const Header& header) {
  return what + " at " + time_text(note.time_ns, header) + " s: " + note.text + "\n";
}

std::string findings_text(const Header& header, const ReplayReport& report) {
  std::string text;
  for (const ReplayNote& fault : report.recorded_faults) text += note_line("stream then", fault, header);
  for (const ReplayNote& fault : report.stream.faults) text += note_line("stream now", fault, header);
  if (report.stream.first_rejected)
    text += note_line("packet rejected first", *report.stream.first_rejected, header);
  if (report.stream.first_different)
    text += note_line("reply different first", *report.stream.first_different, header);
  return text.empty() ? text : "\n" + text;
}

std::string stream_text(const StreamReport& stream) {
  if (stream.datagrams == 0) return "\nNo RSI packet is in it, and nothing was compared\n";
  std::string text = formatted("\nReplies: %llu of %llu compared, %llu different; largest step %.5f deg\n",
                               static_cast<unsigned long long>(stream.compared),
                               static_cast<unsigned long long>(stream.datagrams),
                               static_cast<unsigned long long>(stream.different), stream.max_step_deg);
  for (const std::string& why : stream.not_compared) text += "Not compared: " + why + "\n";
  return text;
}

int run_replay(const Replay& command) {
  const auto recording = Recording::read(config::read_bytes(command.file, kMostBytes));
  if (!recording) throw CommandError{kBadInput, command.file + ": " + recording.error()};
  const auto report = daemon::replay(*recording);
  if (!report) throw CommandError{kBadInput, command.file + ": " + report.error()};
  const Header& header = recording->header();
  const std::string text = command.json ? control::json_text(report_json(header, *report)) + "\n"
                                        : header_text(header, *report) + findings_text(header, *report) +
                                              stream_text(report->stream);
  std::fputs(text.c_str(), stdout);
  if (!report->damage.empty())
    print_to_stderr("truepose: " + command.file + ": " + report->damage + ": read up to there");
  return report->same() ? kDone : kFailed;
}

}  // namespace

Command replay_command() {
  const auto command = std::make_shared<Replay>();
  Replay& c = *command;
  return {
      .name = "replay",
      .help = "Feeds the RSI packets of a recording (pcapng) to the stream again, and compares the replies",
      .options = {Option("FILE", &c.file, "recording", {.required = true, .file = FileUse::Read}),
                  Option("--json", &c.json, "print one JSON document")},
      .run = [command] { return run_replay(*command); }};
}

}  // namespace truepose::tools
