#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "config/text_file.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/offline_commands.hpp"
#include "tools/truepose/online_cli.hpp"

namespace {

int complain(std::string message, int exit_code) {
  std::ranges::replace(message, '\n', ' ');
  std::fprintf(stderr, "truepose: %s\n", message.c_str());
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) try {
  using namespace truepose::tools;
  int exit_code = kDone;
  CLI::App app{"Calibrates industrial robots with a laser tracker, and corrects them while they work.",
               "truepose"};
  app.set_version_flag("--version", "truepose " TRUEPOSE_VERSION);
  app.require_subcommand(1);
  add_calibrate_command(app, exit_code);
  add_compensate_command(app, exit_code);
  add_drift_command(app, exit_code);
  add_experiment_command(app, exit_code);
  add_export_command(app);
  add_fk_command(app);
  add_iso9283_command(app);
  add_plan_command(app);
  add_online_commands(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return complain(std::string(error.what()) + " (see truepose --help)", kBadInput);
  }
  return exit_code;
} catch (const truepose::config::ConfigError& error) {
  return complain(error.what(), truepose::tools::kBadInput);
} catch (const std::exception& error) {
  return complain(error.what(), truepose::tools::kFailed);
}
