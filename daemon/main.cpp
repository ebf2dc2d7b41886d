#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/check.hpp"
#include "daemon/daemon.hpp"
#include "daemon/log/log.hpp"

namespace {

using truepose::daemon::Finding;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;     // the unit does not try again: a person has to mend it
constexpr int kNotThereYet = 3;  // the unit tries again: an address, a port, room on the disk

int complain(const char* what, int exit_code) {
  truepose::daemon::close_log();
  std::fprintf(stderr, "trueposed: %s\n", what);
  return exit_code;
}

void print(const Finding& finding) {
  switch (finding.level) {
    case Finding::Level::Good:
      std::printf("ok       %s\n", finding.text.c_str());
      break;
    case Finding::Level::Warning:
      std::printf("warning  %s\n", finding.text.c_str());
      break;
    case Finding::Level::Failure:
      complain(finding.text.c_str(), kBadInput);
      break;
  }
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
  const std::vector<Finding> findings = truepose::daemon::check(config);
  const auto failed = [](const Finding& finding) { return finding.level == Finding::Level::Failure; };
  if (check_only) {
    for (const Finding& finding : findings) print(finding);
    if (std::any_of(findings.begin(), findings.end(), failed)) return kBadInput;
    std::printf("%s: good\n", file.c_str());
    return 0;
  }
  const auto failure = std::find_if(findings.begin(), findings.end(), failed);
  if (failure != findings.end()) return complain(failure->text.c_str(), kBadInput);
  std::vector<std::string> warnings;
  for (const Finding& finding : findings) {
    if (finding.level == Finding::Level::Warning) warnings.push_back(finding.text);
  }
  truepose::daemon::open_log(config.log_level);
  truepose::daemon::run(config, warnings);
  truepose::daemon::close_log();
  return 0;
} catch (const truepose::config::ConfigError& error) {
  return complain(error.what(), kBadInput);
} catch (const truepose::daemon::StartError& error) {
  return complain(error.what(), error.may_pass() ? kNotThereYet : kBadInput);
} catch (const std::exception& error) {
  return complain(error.what(), kFailed);
}
