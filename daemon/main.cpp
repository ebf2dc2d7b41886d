#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "config/cell_config.hpp"
#include "daemon/daemon.hpp"
#include "daemon/log/log.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int complain(const char* what, int exit_code) {
  truepose::daemon::close_log();
  std::fprintf(stderr, "trueposed: %s\n", what);
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{"Calibrates one robot cell with a laser tracker and corrects its arm while it works.",
               "trueposed"};
  app.set_version_flag("--version", "trueposed " TRUEPOSE_VERSION);
  std::filesystem::path file;
  bool check_only = false;
  app.add_option("--config", file, "cell file")->required();
  app.add_flag("--check", check_only, "check the cell file and every file that it names, and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return complain((std::string{error.what()} + " (see trueposed --help)").c_str(), kBadInput);
  }

  const truepose::config::CellConfig config = truepose::config::load_cell(file);
  truepose::daemon::check(config);
  if (check_only) {
    std::printf("%s: good\n", file.c_str());
    return 0;
  }
  truepose::daemon::open_log(config.log_level);
  truepose::daemon::run(config);
  truepose::daemon::close_log();
  return 0;
} catch (const truepose::config::ConfigError& error) {
  return complain(error.what(), kBadInput);
} catch (const truepose::daemon::StartError& error) {
  return complain(error.what(), kBadInput);
} catch (const std::exception& error) {
  return complain(error.what(), kFailed);
}
