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
#include "proto/recording/shown.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using daemon::DriverReport;
using daemon::ReplayNote;
using daemon::ReplayReport;
using daemon::StreamReport;
using daemon::WireReport;
using recording::Header;
using recording::Record;
using recording::Recording;
using recording::Wire;

constexpr std::size_t kMostBytes = std::size_t{5} << 30;

struct Replay {
  std::string file, wire;
  bool list = false, json = false;

  std::optional<Wire> only() const {
    return wire.empty() ? std::nullopt : std::optional{value_of(recording::kWires, wire)};
  }
};

// ---- Records as lines ----

/// Seconds before the recording was written.
std::string time_text(std::int64_t time_ns, const Header& header) {
  return formatted("%.6f", static_cast<double>(time_ns - header.time_ns) / 1e9);
}

void print_record(const Record& record, const Header& header) {
  const std::string_view wire = name_of(recording::kWires, record.wire);
  const std::string_view kind = name_of(recording::kKinds, record.kind);
  std::printf("%12s  %-9.*s  %-10.*s  %s\n", time_text(record.time_ns, header).c_str(),
              static_cast<int>(wire.size()), wire.data(), static_cast<int>(kind.size()), kind.data(),
              recording::shown(record.bytes).c_str());
}

int list_records(const Replay& command, const Recording& recording) {
  const auto only = command.only();
  const std::string damage = recording.for_each([&](const Record& record) {
    if (!only || record.wire == *only) print_record(record, recording.header());
  });
  if (!damage.empty()) throw CommandError{kFailed, command.file + ": " + damage};
  return kDone;
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

json::object wire_json(const WireReport& wire, const Header& header) {
  return {{"wire", name_of(recording::kWires, wire.wire)},
          {"frames", wire.frames},
          {"decoded", wire.decoded()},
          {"rejected", wire.rejected},
          {"sessions", wire.sessions},
          {"first_rejected", note_json(wire.first_rejected, header)},
          {"regression", note_json(wire.regression, header)}};
}

json::object counters_json(const std::map<std::string, std::uint64_t>& counters) {
  json::object all;
  for (const auto& [name, count] : counters) all[name] = count;
  return all;
}

json::object stream_json(const StreamReport& stream, const Header& header) {
  return {{"datagrams", stream.datagrams},
          {"compared", stream.compared},
          {"different", stream.different},
          {"first_different", note_json(stream.first_different, header)},
          {"not_compared", json::array(stream.not_compared.begin(), stream.not_compared.end())},
          {"faults", notes_json(stream.faults, header)},
          {"counters", counters_json(stream.counters)},
          {"max_step_deg", stream.max_step_deg}};
}

json::object driver_json(const DriverReport& driver, const Header& header) {
  return {{"driver", driver.name},
          {"calls", driver.calls},
          {"same", driver.same},
          {"different", driver.different},
          {"first_different", note_json(driver.first_different, header)},
          {"not_judged", counters_json(driver.not_judged)}};
}

json::object report_json(const Header& header, const ReplayReport& report) {
  json::array wires, drivers, models;
  for (const WireReport& wire : report.wires) wires.push_back(wire_json(wire, header));
  for (const DriverReport& driver : report.drivers) drivers.push_back(driver_json(driver, header));
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
          {"wires", std::move(wires)},
          {"drivers", std::move(drivers)},
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

std::string wires_text(const ReplayReport& report) {
  std::vector<Cells> rows{{"WIRE", "FRAMES", "DECODED", "REJECTED", "SESSIONS"}};
  for (const WireReport& wire : report.wires) {
    rows.push_back({std::string{name_of(recording::kWires, wire.wire)}});
    for (const std::uint64_t count : {wire.frames, wire.decoded(), wire.rejected, wire.sessions})
      rows.back().push_back(std::to_string(count));
  }
  return "\n" + text_table(rows);
}

bool has_devices(const ReplayReport& report) {
  return std::ranges::any_of(report.wires, [](const WireReport& wire) { return wire.wire != Wire::Rsi; });
}

std::string drivers_text(const ReplayReport& report) {
  if (report.drivers.empty()) {
    if (!has_devices(report)) return {};
    return "\nWhat the drivers were asked for is not replayed: their decoders alone read the frames\n";
  }
  std::vector<Cells> rows{{"DRIVER", "CALLS", "SAME", "DIFFERENT", "NOT JUDGED"}};
  std::string why;
  for (const DriverReport& driver : report.drivers) {
    std::uint64_t not_judged = 0;
    for (const auto& [reason, calls] : driver.not_judged) {
      not_judged += calls;
      why += "Not judged: " + driver.name + ": " + std::to_string(calls) + " " + reason + "\n";
    }
    rows.push_back({driver.name});
    for (const std::uint64_t count : {driver.calls, driver.same, driver.different, not_judged})
      rows.back().push_back(std::to_string(count));
  }
  return "\n" + text_table(rows) + why;
}

std::string note_line(const std::string& what, const ReplayNote& note, const Header& header) {
  return what + " at " + time_text(note.time_ns, header) + " s: " + note.text + "\n";
}

std::string findings_text(const Header& header, const ReplayReport& report) {
  std::string text;
  for (const ReplayNote& fault : report.recorded_faults) text += note_line("stream then", fault, header);
  for (const ReplayNote& fault : report.stream.faults) text += note_line("stream now", fault, header);
  for (const WireReport& wire : report.wires) {
    const std::string name{name_of(recording::kWires, wire.wire)};
    if (wire.first_rejected) text += note_line(name + " rejected first", *wire.first_rejected, header);
    if (wire.regression)
      text += note_line(name + " accepted then and rejected now", *wire.regression, header);
  }
  for (const DriverReport& driver : report.drivers)
    if (driver.first_different)
      text += note_line(driver.name + " different first", *driver.first_different, header);
  if (report.stream.first_different)
    text += note_line("reply different first", *report.stream.first_different, header);
  return text.empty() ? text : "\n" + text;
}

std::string stream_text(const StreamReport& stream) {
  if (stream.datagrams == 0) return {};
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
  if (command.list) return list_records(command, *recording);
  const auto report = daemon::replay(*recording, command.only());
  if (!report) throw CommandError{kBadInput, command.file + ": " + report.error()};
  const Header& header = recording->header();
  const std::string text = command.json
                               ? control::json_text(report_json(header, *report)) + "\n"
                               : header_text(header, *report) + wires_text(*report) + drivers_text(*report) +
                                     findings_text(header, *report) + stream_text(report->stream);
  std::fputs(text.c_str(), stdout);
  if (!report->damage.empty())
    say_beside("truepose: " + command.file + ": " + report->damage + ": read up to there");
  return report->same() ? kDone : kFailed;
}

}  // namespace

Command replay_command() {
  const auto command = std::make_shared<Replay>();
  Replay& c = *command;
  std::vector<std::string> wires;
  for (const std::string_view name : names_of(recording::kWires)) wires.emplace_back(name);
  return {.name = "replay",
          .help = "Feeds a recording of the daemon's to the drivers and the stream again",
          .options = {Option("FILE", &c.file, "recording", {.required = true, .file = FileUse::Read}),
                      Option("--wire", &c.wire, "this wire alone", {.check = member_of(wires)}),
                      Option("--list", &c.list, "print its records instead, a line each"),
                      Option("--json", &c.json, "print one JSON document", {.excludes = {"--list"}})},
          .run = [command] { return run_replay(*command); }};
}

}  // namespace truepose::tools
