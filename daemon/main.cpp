#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <boost/asio/multiple_exceptions.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "config/program_options.hpp"
#include "daemon/check.hpp"
#include "daemon/control/version_text.hpp"
#include "daemon/daemon.hpp"
#include "daemon/device_probe.hpp"
#include "daemon/log/log.hpp"
#include "daemon/process.hpp"

namespace {

namespace config = truepose::config;
using config::UsageError;
using truepose::daemon::CheckFinding;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;     // the unit does not restart: the operator has to fix it
constexpr int kNotThereYet = 3;  // the unit tries again: an address, a port, room on the disk, the time

constexpr const char* kHelp =
    R"(Calibrates one robot cell with a laser tracker and corrects its arm while it works.
Usage: trueposed --config FILE [--check [--probe]]

  --config FILE  cell file
  --check        check the cell file and every file that it names, and exit
  --probe        with --check: ask robot and tracker who they are; moves and changes nothing
  --version      print the version and exit
  -h, --help     print this and exit
)";

void complain(const std::string& what) { std::fprintf(stderr, "trueposed: %s\n", what.c_str()); }

/// Says why it ends, behind all that is still to be logged. @return the exit code
int end(const std::string& why, int exit_code) {
  if (!truepose::daemon::close_log()) ::_exit(exit_code);
  complain(why);
  return exit_code;
}

/// What happened, of several the first, and what was its cause.
std::string sentence_of(const std::exception& error) {
  const auto cause_of = [](const std::exception_ptr& cause) -> std::string {
    try {
      if (cause) std::rethrow_exception(cause);
    } catch (const std::exception& found) {
      return sentence_of(found);
    } catch (...) {
    }
    return "unknown";
  };
  if (const auto* const several = dynamic_cast<const boost::asio::multiple_exceptions*>(&error))
    return cause_of(several->first_exception());
  if (const auto* const nested = dynamic_cast<const std::nested_exception*>(&error))
    return std::string{error.what()} + ": " + cause_of(nested->nested_ptr());
  return error.what();
}

/// Why the daemon cannot start: a failure for the operator to fix before one that may pass. Null: it can
/// start.
const CheckFinding* first_failure(const std::vector<CheckFinding>& findings) {
  const CheckFinding* first = nullptr;
  for (const CheckFinding& finding : findings) {
    if (finding.level != CheckFinding::Level::Failure) continue;
    if (!finding.may_pass) return &finding;
    if (first == nullptr) first = &finding;
  }
  return first;
}

int exit_code(const CheckFinding& failure) { return failure.may_pass ? kNotThereYet : kBadInput; }

void print(const CheckFinding& finding) {
  switch (finding.level) {
    case CheckFinding::Level::Good:
      std::printf("ok       %s\n", finding.text.c_str());
      break;
    case CheckFinding::Level::Warning:
      std::printf("warning  %s\n", finding.text.c_str());
      break;
    case CheckFinding::Level::Failure:
      complain(finding.text);
      break;
  }
}

/// @return the exit code that they amount to
int print_all(const std::vector<CheckFinding>& findings) {
  for (const CheckFinding& finding : findings) print(finding);
  const CheckFinding* const failure = first_failure(findings);
  return failure ? exit_code(*failure) : 0;
}

struct Arguments {
  std::filesystem::path file;
  bool check_only = false;
  bool probe = false;
  bool version = false;
};

using Known = config::ProgramOption<Arguments>;

constexpr std::array kKnown{Known{"config", [](Arguments& a) { a.file = optarg; }},
                            Known{"check", [](Arguments& a) { a.check_only = true; }, no_argument},
                            Known{"probe", [](Arguments& a) { a.probe = true; }, no_argument},
                            Known{"version", [](Arguments& a) { a.version = true; }, no_argument}};

/// @return none where a text was asked for, and is printed. Throws UsageError
std::optional<Arguments> read_arguments(int argc, char** argv) {
  auto arguments = config::read_options<Arguments>(argc, argv, kKnown, kHelp);
  if (!arguments) return std::nullopt;
  if (arguments->version) {
    std::puts(truepose::daemon::version_text("trueposed").c_str());
    return std::nullopt;
  }
  if (arguments->file.empty()) throw UsageError{std::string{"--config is required"} + config::kSeeHelp};
  if (arguments->probe && !arguments->check_only)
    throw UsageError{std::string{"--probe needs --check"} + config::kSeeHelp};
  return arguments;
}

/// Ends of a process that leave a correction in effect, for reasons that are none: a log without a reader
/// any more or that has grown to its limit, and signals that mean nothing here.
void ignore_signals() {
  for (const int ignored : {SIGPIPE, SIGXFSZ, SIGUSR1, SIGUSR2}) ::signal(ignored, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) try {
  ignore_signals();
  // Whatever the caller's is, what the daemon keeps is no business of others.
  ::umask(::umask(0077) | 0027);
  const auto arguments = read_arguments(argc, argv);
  if (!arguments) return 0;
  const std::filesystem::path& file = arguments->file;
  const config::CellConfig config = config::load_cell(file);
  const std::vector<CheckFinding> findings = truepose::daemon::check(config);
  if (arguments->check_only) {
    if (const int failed = print_all(findings)) return failed;
    if (arguments->probe && print_all(truepose::daemon::probe(config)) != 0) return kNotThereYet;
    std::printf("%s: good\n", file.c_str());
    return 0;
  }
  if (const CheckFinding* const failure = first_failure(findings))
    return end(failure->text, exit_code(*failure));
  std::vector<std::string> warnings;
  for (const CheckFinding& finding : findings) {
    if (finding.level == CheckFinding::Level::Warning) warnings.push_back(finding.text);
  }
  truepose::daemon::open_log(config.log_level);
  truepose::daemon::run(config, warnings);
  if (!truepose::daemon::close_log()) ::_exit(0);
  return 0;
} catch (const UsageError& error) {
  return end(error.what(), kBadInput);
} catch (const config::ConfigError& error) {
  return end(error.what(), kBadInput);
} catch (const truepose::daemon::StartError& error) {
  return end(error.what(), error.may_pass() ? kNotThereYet : kBadInput);
} catch (const std::exception& error) {
  return end(sentence_of(error), kFailed);
}
