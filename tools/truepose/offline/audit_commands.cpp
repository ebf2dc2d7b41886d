// Whether the audit trail of a cell is what the daemon wrote.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <regex>
#include <sstream>
#include <vector>

#include "config/cell_config.hpp"
#include "config/text_file.hpp"
#include "daemon/control/audit_files.hpp"
#include "daemon/store/store.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::daemon {

void layout(record::Io& io, AuditFault& x) {
  io("record", x.number);
  io("text", x.text);
  io("by", x.acknowledged_by);
}

}  // namespace truepose::daemon

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;

/// What is printed as JSON.
struct VerifiedTrail {
  fs::path file;
  control::AuditHead end;
  std::vector<daemon::AuditFault> acknowledged;
};
void layout(record::Io& io, VerifiedTrail& x) {
  io("file", x.file);
  io("records", x.end.count);
  io("head", x.end.hash);
  io("acknowledged", x.acknowledged);
}

struct Verify {
  std::string cell_file;
  fs::path journal;
  bool json = false;
};

/// Where the trail once ended, as the daemon has logged ("audit trail: 40 records, head 3f..").
std::vector<control::AuditHead> logged_heads(const fs::path& journal) {
  static const std::regex kLine{R"(audit trail: (\d{1,18}) records, head ([0-9a-f]{64}))"};
  std::vector<control::AuditHead> heads;
  std::istringstream text{config::read_text_file(journal)};
  std::smatch found;
  for (std::string line; std::getline(text, line);)
    if (std::regex_search(line, found, kLine)) heads.push_back({std::stoull(found[1]), found[2]});
  return heads;
}

/// What the store, and a log, know of the trail.
std::vector<control::AuditHead> known_heads(const Verify& command, const fs::path& store) {
  std::vector<control::AuditHead> heads;
  if (!command.journal.empty()) heads = logged_heads(command.journal);
  if (!fs::exists(store)) return heads;
  auto opened = daemon::Store::open_to_read(store);
  auto known = opened ? opened->audit_heads() : std::unexpected(opened.error());
  if (!known)
    throw CommandError{kFailed,
                       "what the store knows of its audit trail cannot be read: " + known.error().detail};
  heads.insert(heads.end(), known->begin(), known->end());
  return heads;
}

int run_verify(const Verify& command) {
  const fs::path store = config::load_cell(command.cell_file).store, trail = daemon::audit_file_of(store);
  const std::string place = "audit trail " + trail.string() + ": ";
  const auto report = daemon::verify_audit(trail, known_heads(command, store));
  if (!report) throw CommandError{kFailed, place + report.error()};
  for (const daemon::AuditFault& fault : report->faults) {
    const std::string what = "before record " + std::to_string(fault.number) + ": " + fault.text;
    if (fault.acknowledged_by.empty())
      throw CommandError{kFailed, place + what +
                                      "; this is not acknowledged: find out who did it, then "
                                      "`truepose audit acknowledge --name NAME`"};
    if (!command.json) std::printf("%s; acknowledged by %s\n", what.c_str(), fault.acknowledged_by.c_str());
  }
  if (command.json) {
    const VerifiedTrail found{trail, report->end, report->faults};
    std::printf("%s\n", control::json_text(record::to_json(found)).c_str());
    return kDone;
  }
  std::printf("%s: %llu records, none changed and none missing%s\n", trail.c_str(),
              static_cast<unsigned long long>(report->end.count),
              report->faults.empty() ? "" : " but what was acknowledged");
  return kDone;
}

}  // namespace

Command audit_verify_command() {
  const auto command = std::make_shared<Verify>();
  return {
      .name = "audit verify",
      .help = "Checks that the audit log is what the daemon wrote, and complete",
      .options =
          {Option("--cell", &command->cell_file, "Cell file",
                  {.required = true, .place = "CELL", .file = FileUse::Read}),
           Option(
               "--journal", &command->journal,
               "Log of the daemon (journalctl -o cat): the ends of the trail that it has must be in the audit log",
               {.file = FileUse::Read}),
           Option("--json", &command->json,
                  "Print one JSON document: the file, its number of records, the hash of the last, what was "
                  "acknowledged")},
      .run = [command] { return run_verify(*command); },
      .examples = {{"audit verify cell.yaml"}}};
}

}  // namespace truepose::tools
