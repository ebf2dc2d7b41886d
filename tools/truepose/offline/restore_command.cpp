// A backup in the place of a cell's store.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/store/restore.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

struct RestoreCommand {
  std::string backup, cell_file;
};

/// "20261124T235959Z"
std::string time_in_name() {
  std::string name;
  for (const char letter : control::rfc3339(std::chrono::system_clock::now()).substr(0, 19))
    if (letter != '-' && letter != ':') name += letter;
  return name + "Z";
}

int run_restore(const RestoreCommand& command) {
  const std::filesystem::path store = config::load_cell(command.cell_file).store;
  const auto aside = daemon::restore_store(command.backup, store, time_in_name());
  if (!aside) throw CommandError{kFailed, "restore: " + aside.error()};
  std::printf("%s is the store now; its stream is not armed\n", store.c_str());
  if (!aside->empty()) std::printf("what was there is kept as %s\n", aside->c_str());
  return kDone;
}

}  // namespace

Command restore_command() {
  const auto command = std::make_shared<RestoreCommand>();
  return {.name = "restore",
          .help = "Puts a backup in the place of a cell's store, while no daemon has that",
          .options = {Option("FILE", &command->backup, "Backup, or any copy of a store",
                             {.required = true, .file = FileUse::Read}),
                      Option("--cell", &command->cell_file, "Cell file",
                             {.required = true, .file = FileUse::Read})},
          .run = [command] { return run_restore(*command); },
          .task = Task::Cell,
          .examples = {{"restore store.backup --cell cell.yaml"}}};
}

}  // namespace truepose::tools
