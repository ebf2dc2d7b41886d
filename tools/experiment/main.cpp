#include <fmt/format.h>
#include <getopt.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/program_options.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/math/parallel.hpp"
#include "core/simulate/published_arm.hpp"
#include "daemon/report/number_text.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/experiment/experiment_page.hpp"
#include "tools/steering/exit_code.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"

namespace {

using namespace truepose;
using report::error_text;
using tools::Cells, tools::text_table;

constexpr const char* kHelp =
    R"(Compares all methods on a simulated arm with the published figures.
Usage: truepose-experiment [OPTIONS]

Options:
  -h,--help       Print this help message and exit
  --robot FILE    robot file (YAML) of six revolute joints; left out: the KR 210 R2700-2
  --seed UINT     of all random numbers; left out: 0
  --trials INT    placements, poses and noise drawn for each method, 1 to 100000; left out: 200
  --jobs INT      threads, 1 to 1024; the result is the same with any number; left out: one a processor
  --report FILE   write a page here (HTML, one file)
  --json          print one JSON document
)";

struct Options {
  std::filesystem::path robot_file, report_file;  ///< empty = the paper's arm, no report
  ExperimentOptions experiment;
  int jobs = processor_count();
  bool as_json = false;
};

using Known = config::ProgramOption<Options>;

constexpr std::array kKnown{
    Known{"robot", [](Options& o) { o.robot_file = optarg; }},
    Known{"seed", [](Options& o) { o.experiment.seed = config::number_of<std::uint64_t>("--seed"); }},
    Known{"trials",
          [](Options& o) {
            o.experiment.trials =
                config::number_of<int>("--trials", "a whole number from 1 to 100000", 1, 100'000);
          }},
    Known{"jobs",
          [](Options& o) {
            o.jobs = config::number_of<int>("--jobs", "a whole number from 1 to 1024", 1, 1024);
          }},
    Known{"report", [](Options& o) { o.report_file = optarg; }},
    Known{"json", [](Options& o) { o.as_json = true; }, no_argument}};

// ---- As tables, mm ----

std::string methods_text(const ExperimentResult& result) {
  std::vector<Cells> rows{{"Method", "mean", "max", "RMS", "RMS/bound", "converged", "iter", "time"}};
  for (const MethodResult& method : result.methods) {
    const auto figure = [&](double ErrorStatistics::*mm) {
      return method.validation ? error_text(*method.validation.*mm) : "-";
    };
    rows.push_back({title_of(method), figure(&ErrorStatistics::mean), figure(&ErrorStatistics::max),
                    figure(&ErrorStatistics::rms),
                    method.rmse_over_bound > 0 ? fmt::format("{:.3f}", method.rmse_over_bound) : "-",
                    fmt::format("{:.1f} %", 100 * method.converged), fmt::format("{:.1f}", method.iterations),
                    fmt::format("{:.1f} ms", 1000 * method.time_s)});
  }
  return text_table({{-40}, {12}, {12}, {12}, {13}, {11}, {7}, {9}}, rows);
}

std::string designs_text(const ExperimentResult& result) {
  std::vector<Cells> rows{{"Poses chosen", "poses", "RMS", "max"}};
  for (const DesignResult& design : result.designs)
    rows.push_back(
        {design.design, std::to_string(design.poses), error_text(design.rms_mm), error_text(design.max_mm)});
  return "\n" + text_table({{-40}, {7}, {9}, {9}}, rows);
}

std::string layers_text(const ExperimentResult& result) {
  std::vector<Cells> rows;
  std::string last;
  for (const LayerResult& layer : result.layers) {
    if (const std::string arm = arm_title(layer); arm != last) {
      rows.push_back({});
      rows.push_back({arm, "mean", "max", "RMS"});
      last = arm;
    }
    rows.push_back({"  " + layer.layer, error_text(layer.validation.mean), error_text(layer.validation.max),
                    error_text(layer.validation.rms)});
  }
  return text_table({{-40}, {9}, {9}, {9}}, rows);
}

std::string published_text(const ExperimentResult& result) {
  std::vector<Cells> rows{{"Mean error, the paper's and ours", "paper", "ours"}};
  for (const PublishedComparison& pair : result.published) {
    rows.push_back({pair.figure, error_text(pair.published_mean_mm), error_text(pair.mean_mm)});
    rows.push_back(
        {fmt::format("    {} ({}).", pair.explanation.substr(0, pair.explanation.size() - 1), pair.source)});
  }
  return "\n" + text_table({{-40}, {9}, {9}}, rows);
}

std::string experiment_text(const ExperimentOptions& options, const ExperimentResult& result) {
  return fmt::format(
             "{} trials (seed {}), {} + {} random poses each, tracker {} mm and repeatability {} mm per "
             "axis.\nErrors in mm at validation poses; the Cramer-Rao bound of their RMS is {} mm.\n\n",
             options.trials, options.seed, options.identify_poses, options.validate_poses,
             error_text(options.tracker_noise_mm), error_text(options.repeatability_mm),
             error_text(result.bound_rms_mm)) +
         methods_text(result) + designs_text(result) + layers_text(result) + published_text(result);
}

// ---- The run ----

/// What the thread has had of the processor: others' fits do not count.
double thread_time_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

ExperimentResult result_of(const Options& options) {
  const RobotModel robot =
      options.robot_file.empty() ? published_arm() : config::load_robot(options.robot_file);
  tools::ProgressLine line{"experiment"};
  const ExperimentHooks hooks{
      .clock_s = thread_time_s,
      .progress = [&](double share, std::string_view doing) { line.show(share, doing); },
      .jobs = options.jobs};
  auto result = run_experiment(robot, options.experiment, hooks);
  if (!result) throw config::ConfigError(options.robot_file.string() + ": " + result.error());
  return *std::move(result);
}

/// Whether the method that all of this is about converged in every trial.
bool worked(const ExperimentResult& result) {
  return std::ranges::all_of(result.methods, [](const MethodResult& m) {
    return m.method != "two-stage" || m.data == TrialData::GrossErrors || m.converged == 1;
  });
}

int run(const Options& options) {
  const ExperimentDocument document{options.experiment, result_of(options)};
  const std::string text = options.as_json ? control::json_text(record::to_json(document)) + "\n"
                                           : experiment_text(options.experiment, document.result);
  std::fputs(text.c_str(), stdout);  // first, so that a report that cannot be written costs no minutes
  if (!options.report_file.empty())
    config::write_text_file(options.report_file, report::render_experiment_html(document));
  if (worked(document.result)) return steering::kDone;
  std::fputs(
      "truepose-experiment: the two-stage fit did not converge in every trial: see its share of trials\n",
      stderr);
  return steering::kFailed;
}

}  // namespace

int main(int argc, char** argv) try {
  const auto options = config::read_options<Options>(argc, argv, kKnown, kHelp);
  return options ? run(*options) : steering::kDone;
} catch (const std::exception& e) {
  std::fprintf(stderr, "truepose-experiment: %s\n", e.what());
  return steering::kBadInput;
}
