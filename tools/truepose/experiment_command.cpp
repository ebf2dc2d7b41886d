#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/simulate/published_arm.hpp"
#include "proto/control/json_text.hpp"
#include "tools/experiment/experiment.hpp"
#include "tools/report/report.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/experiment_document.hpp"
#include "tools/truepose/experiment_text.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

struct ExperimentCommand {
  std::filesystem::path robot_file, report_file;  ///< empty = the paper's arm, no report
  ExperimentOptions options;
  bool as_json = false;
};

double monotonic_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// One line that is written over and, at the end, wiped away; nothing where no one watches.
class ProgressLine {
 public:
  ~ProgressLine() {
    if (watched_) std::fputs("\r\x1b[K", stderr);
  }
  void show(double share, std::string_view doing) {
    if (!watched_) return;
    std::fprintf(stderr, "\r\x1b[K%3.0f %% of the %.*s", 100 * share, static_cast<int>(doing.size()),
                 doing.data());
    std::fflush(stderr);
  }

 private:
  bool watched_ = isatty(STDERR_FILENO) == 1;
};

ExperimentResult run(const ExperimentCommand& command) {
  const RobotModel robot =
      command.robot_file.empty() ? published_arm() : config::load_robot(command.robot_file);
  ProgressLine line;
  const ExperimentHooks hooks{.clock_s = monotonic_s, .progress = [&](double share, std::string_view doing) {
                                line.show(share, doing);
                              }};
  auto result = run_experiment(robot, command.options, hooks);
  if (!result) throw config::ConfigError(command.robot_file.string() + ": " + result.error());
  return *std::move(result);
}

/// Whether the method that all of this is about converged in every trial.
bool worked(const ExperimentResult& result) {
  return std::ranges::all_of(result.methods, [](const MethodResult& m) {
    return m.method != "two-stage" || m.data == TrialData::GrossErrors || m.converged == 1;
  });
}

int run_experiment_command(const ExperimentCommand& command) {
  const ExperimentResult result = run(command);
  const json::object document = experiment_document(command.options, result);
  const std::string text =
      command.as_json ? control::json_text(document) + "\n" : experiment_text(command.options, result);
  std::fputs(text.c_str(), stdout);  // first, so that a report that cannot be written costs no minutes
  if (!command.report_file.empty())
    config::write_text_file(command.report_file, report::render_experiment_html(document));
  if (worked(result)) return kDone;
  std::fputs("truepose: the two-stage fit did not converge in every trial: see its share of trials\n",
             stderr);
  return kFailed;
}

}  // namespace

void add_experiment_command(CLI::App& app, int& exit_code) {
  const auto command = std::make_shared<ExperimentCommand>();
  CLI::App* sub = app.add_subcommand("experiment",
                                     "Compares all methods on a simulated arm, beside the published figures");
  sub->add_option("--robot", command->robot_file,
                  "Robot file (YAML) of six revolute joints; without it the KR 210 R2700-2");
  sub->add_option("--seed", command->options.seed, "Of all random numbers")->capture_default_str();
  sub->add_option("--trials", command->options.trials, "Placements, poses and noise drawn for each method")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  sub->add_option("--report", command->report_file, "Write a report here (HTML, one file)");
  sub->add_flag("--json", command->as_json, "One JSON document");
  sub->callback([command, &exit_code] { exit_code = run_experiment_command(*command); });
}

}  // namespace truepose::tools
