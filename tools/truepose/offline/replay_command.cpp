#include <algorithm>
#include <cstdio>
#include <memory>

#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "daemon/replay/replay.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/recording/recording.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

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

/// A note with its time since the recording was written.
struct SinceWritten {
  struct Form {
    double time_s;
    std::string text;
  };
  std::int64_t written_ns;
  Form form_of(const ReplayNote& note) const {
    return {static_cast<double>(note.time_ns - written_ns) / 1e9, note.text};
  }
};
void layout(record::Io& io, SinceWritten::Form& x) {
  io("time_s", x.time_s);
  io("text", x.text);
}

struct ModelDigest {
  struct Form {
    std::string id, sha256;
  };
  static Form form_of(const recording::Model& model) { return {model.id, model.sha256}; }
};
void layout(record::Io& io, ModelDigest::Form& x) {
  io("id", x.id);
  io("sha256", x.sha256);
}

struct ReplayedStream {
  StreamReport stream;
  SinceWritten since;
};
void layout(record::Io& io, ReplayedStream& x) {
  io("datagrams", x.stream.datagrams);
  io("rejected", x.stream.rejected);
  io.nullable("first_rejected", x.stream.first_rejected, x.since);
  io("sessions", x.stream.sessions);
  io("compared", x.stream.compared);
  io("different", x.stream.different);
  io.nullable("first_different", x.stream.first_different, x.since);
  io("not_compared", x.stream.not_compared);
  io("faults", x.stream.faults, x.since);
  io("counters", x.stream.counters);
  io("max_step_deg", x.stream.max_step_deg);
}

struct ReplayDocument {
  Header header;
  ReplayReport report;
};
void layout(record::Io& io, ReplayDocument& x) {
  const SinceWritten since{x.header.time_ns};
  io("product", x.header.product);
  io("cell", x.header.cell);
  io("date", x.header.date);
  io("reason", x.header.reason);
  io("robot", x.header.robot);
  io("tracker", x.header.tracker);
  io("models", x.header.models, ModelDigest{});
  io("records", x.report.records);
  io("dropped", x.report.dropped);
  io("seconds", static_cast<double>(x.report.end_ns - x.report.begin_ns) / 1e9);
  io("damage", x.report.damage);
  io("stream", ReplayedStream{x.report.stream, since});
  io("recorded_faults", x.report.recorded_faults, since);
  io("same", x.report.same());
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
  const std::string text =
      command.json
          ? control::json_text(record::to_json(ReplayDocument{header, *report})) + "\n"
          : header_text(header, *report) + findings_text(header, *report) + stream_text(report->stream);
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
      .options = {Option("FILE", &c.file, "Recording (pcapng)", {.required = true, .file = FileUse::Read}),
                  Option("--json", &c.json, "One JSON document")},
      .run = [command] { return run_replay(*command); },
      .task = Task::Diagnosis,
      .examples = {{"replay 20260131T120000Z.pcapng"}}};
}

}  // namespace truepose::tools
