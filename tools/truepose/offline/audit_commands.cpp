// Whether the audit trail of a cell is what the daemon wrote.
#include <boost/json/object.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/cell_config.hpp"
#include "daemon/control/audit_trail.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

struct Verify {
  std::string cell_file;
  bool json = false;
};

int run_verify(const Verify& command) {
  const std::filesystem::path trail = daemon::audit_file_of(config::load_cell(command.cell_file).store);
  const auto end = daemon::verify_audit(trail);
  if (!end) throw CommandError{kFailed, "audit trail " + trail.string() + ": " + end.error()};
  if (command.json) {
    const boost::json::object found{{"file", trail.string()}, {"records", end->count}, {"head", end->hash}};
    std::printf("%s\n", control::json_text(found).c_str());
    return kDone;
  }
  std::printf("%s: %llu records, none changed and none missing\n", trail.c_str(),
              static_cast<unsigned long long>(end->count));
  return kDone;
}

}  // namespace

Command audit_verify_command() {
  const auto command = std::make_shared<Verify>();
  return {
      .name = "audit verify",
      .help = "Whether what stands on record is what the daemon wrote, and all of it",
      .options = {Option("--cell", &command->cell_file, "Cell file",
                         {.required = true, .file = FileUse::Read}),
                  Option("--json", &command->json,
                         "Print one JSON document: the file, its number of records, the hash of the last")},
      .run = [command] { return run_verify(*command); }};
}

}  // namespace truepose::tools
