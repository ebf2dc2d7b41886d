// Whether the audit trail of a cell is what the daemon wrote.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "config/cell_config.hpp"
#include "daemon/control/audit_trail.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

int run_verify(const std::string& cell_file) {
  const std::filesystem::path trail = daemon::audit_file_of(config::load_cell(cell_file).store);
  const auto end = daemon::verify_audit(trail);
  if (!end) throw CommandError{kFailed, "audit trail " + trail.string() + ": " + end.error()};
  std::printf("%s: %llu records, none changed and none missing\n", trail.c_str(),
              static_cast<unsigned long long>(end->count));
  return kDone;
}

}  // namespace

Command audit_verify_command() {
  const auto cell_file = std::make_shared<std::string>();
  return {
      .name = "audit verify",
      .help = "Whether what stands on record is what the daemon wrote, and all of it",
      .options = {Option("--cell", cell_file.get(), "Cell file", {.required = true, .file = FileUse::Read})},
      .run = [cell_file] { return run_verify(*cell_file); }};
}

}  // namespace truepose::tools
