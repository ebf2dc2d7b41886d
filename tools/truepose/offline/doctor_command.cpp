#include <algorithm>
#include <memory>

#include "config/cell_config.hpp"
#include "core/named.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/doctor/probes.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

constexpr std::array kLevels{Named{"ok", Level::Ok}, Named{"warning", Level::Warning},
                             Named{"fault", Level::Fault}};

void layout(record::Io& io, Finding& x) {
  io("area", x.area);
  io("level", x.level, kLevels);
  io("code", x.message.code);
  io("finding", x.message.what);
  io("next", x.message.what_to_do);
}

namespace {

struct DoctorCommand {
  std::string cell_file;
  OnlineOptions online;
};

std::string findings_text(const Findings& findings) {
  std::vector<Cells> rows;
  AnswerText answer;
  for (const Finding& one : findings)
    rows.push_back({std::string{name_of(kLevels, one.level)}, one.area, answer.add(one.message)});
  return text_table(rows);
}

int run_doctor(const DoctorCommand& command) {
  const config::CellConfig cell = config::load_cell(command.cell_file);
  const Observations seen = observe(cell, command.online);
  const Findings findings = diagnose(command.cell_file, cell, seen);
  print(command.online.json ? control::json_text(record::to_json(findings)) + "\n" : findings_text(findings));
  const bool fault = std::ranges::any_of(findings, [](const Finding& f) { return f.level == Level::Fault; });
  return fault ? kFailed : kDone;
}

}  // namespace

Command doctor_command() {
  const auto command = std::make_shared<DoctorCommand>();
  DoctorCommand& c = *command;
  return {
      .name = "doctor",
      .help =
          "Why nothing moves: looks at cell file, daemon, RSI, robot, tracker and this PC, and changes nothing",
      .options = {Option("--cell", &c.cell_file, "Cell file",
                         {.required = true, .place = "CELL", .file = FileUse::Read}),
                  Option("--daemon", &c.online.daemon,
                         "HOST:PORT of the daemon, or the path of its control socket; default: the cell's",
                         {.type = "HOST:PORT"}),
                  Option("--token-file", &c.online.token_file,
                         "File with the daemon's token, for HOST:PORT; default: the cell's",
                         {.environment = "TRUEPOSE_TOKEN_FILE", .file = FileUse::Read}),
                  Option("--json", &c.online.json,
                         "Print one JSON document: a list of {area, level, code, finding, next}")},
      .run = [command] { return run_doctor(*command); },
      .task = Task::Diagnosis,
      .examples = {{"doctor cell.yaml"}}};
}

}  // namespace truepose::tools
