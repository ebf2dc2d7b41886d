#include <fmt/format.h>
#include <getopt.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>
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
#include "proto/record/calibration_document.hpp"
#include "tools/experiment/experiment.hpp"
#include "tools/experiment/experiment_page.hpp"
#include "tools/steering/exit_code.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"

namespace {

using namespace truepose;
namespace json = boost::json;
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

// ---- As a document ----

json::object noise_json(const ExperimentOptions& options) {
  return {
      {"tracker", options.tracker_noise_mm},
      {"repeatability", options.repeatability_mm},
      {"gross",
       {{"fraction", options.gross.fraction}, {"min", options.gross.min_mm}, {"max", options.gross.max_mm}}},
      {"guess",
       {{"base", options.guess.base_mm},
        {"base_rad", options.guess.base_rad},
        {"smr", options.guess.smr_mm}}}};
}

std::string_view name_of(TrialData data) {
  switch (data) {
    case TrialData::NoiseFree:
      return "noise-free";
    case TrialData::Noisy:
      return "noisy";
    case TrialData::GrossErrors:
      break;
  }
  return "outliers";
}

json::object method_json(const MethodResult& method) {
  json::object object{{"method", method.method},
                      {"data", name_of(method.data)},
                      {"validation", nullptr},
                      {"quartiles", nullptr},
                      {"rmse_over_bound", nullptr},
                      {"converged", method.converged},
                      {"iterations", method.iterations},
                      {"time_s", method.time_s},
                      {"convergence", json::value_from(method.convergence_mm)},
                      {"errors", json::value_from(method.errors_mm)}};
  if (method.validation.count > 0) {
    object["validation"] = record::statistics_json(method.validation);
    object["quartiles"] = {method.quartiles.lower, method.quartiles.median, method.quartiles.upper};
    if (method.data != TrialData::NoiseFree) object["rmse_over_bound"] = method.rmse_over_bound;
  }
  if (method.data == TrialData::GrossErrors)
    object["within_2_percent_of_oracle"] = method.within_2_percent_of_oracle;
  return object;
}

json::object design_json(const DesignResult& design) {
  return {{"design", design.design}, {"poses", design.poses}, {"rms", design.rms_mm}, {"max", design.max_mm}};
}

json::object layer_json(const LayerResult& layer) {
  return {{"layer", layer.layer},
          {"rigid", layer.rigid},
          {"poses", layer.poses},
          {"backlash_deg", layer.backlash_deg},
          {"validation", record::statistics_json(layer.validation)},
          {"model_rms", layer.model_rms_mm}};
}

json::object published_json(const PublishedComparison& pair) {
  return {{"figure", pair.figure},
          {"source", pair.source},
          {"published_mean", pair.published_mean_mm},
          {"mean", pair.mean_mm},
          {"explanation", pair.explanation}};
}

template <typename Row>
json::array rows_json(const std::vector<Row>& rows, json::object (*row_json)(const Row&)) {
  json::array array;
  for (const Row& row : rows) array.push_back(row_json(row));
  return array;
}

/// The JSON document of one experiment, mm: {"seed","trials","noise","bound_rms",
/// "methods":[{"method","data","validation":S,"quartiles":[lower,median,upper],"rmse_over_bound","converged",
/// "iterations","time_s","within_2_percent_of_oracle","convergence":[..]}],
/// "designs":[{"design","poses","rms","max"}],
/// "layers":[{"layer","rigid","poses","backlash_deg","validation":S,"model_rms"}],
/// "published":[{"figure","source","published_mean","mean","explanation"}]}.
///
/// "rmse_over_bound" is null without noise, "within_2_percent_of_oracle" is there with outliers alone. S is
/// record::statistics_json; of a method without any fit it is null, as are its quartiles.
json::object experiment_document(const ExperimentOptions& options, const ExperimentResult& result) {
  return {{"seed", options.seed},
          {"trials", options.trials},
          {"noise", noise_json(options)},
          {"bound_rms", result.bound_rms_mm},
          {"methods", rows_json(result.methods, method_json)},
          {"designs", rows_json(result.designs, design_json)},
          {"layers", rows_json(result.layers, layer_json)},
          {"published", rows_json(result.published, published_json)}};
}

// ---- As tables, mm ----

std::string_view suffix_of(TrialData data) {
  switch (data) {
    case TrialData::NoiseFree:
      return ", noise-free";
    case TrialData::Noisy:
      return "";
    case TrialData::GrossErrors:
      break;
  }
  return ", outliers";
}

std::string methods_text(const ExperimentResult& result) {
  std::vector<Cells> rows{{"Method", "mean", "max", "RMS", "RMS/bound", "converged", "iter", "time"}};
  for (const MethodResult& method : result.methods) {
    const ErrorStatistics& errors = method.validation;
    const auto of_fitted = [&](double mm) { return method.validation.count > 0 ? error_text(mm) : "-"; };
    rows.push_back({method.method + std::string(suffix_of(method.data)), of_fitted(errors.mean),
                    of_fitted(errors.max), of_fitted(errors.rms),
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

bool same_arm(const LayerResult& a, const LayerResult& b) {
  return a.rigid == b.rigid && a.poses == b.poses && a.backlash_deg == b.backlash_deg;
}

std::string layers_text(const ExperimentResult& result) {
  std::vector<Cells> rows;
  const LayerResult* last = nullptr;
  for (const LayerResult& layer : result.layers) {
    if (last == nullptr || !same_arm(*last, layer)) {
      const std::string arm = layer.rigid ? std::string("Rigid arm")
                                          : fmt::format("Heavy arm, backlash {} deg", layer.backlash_deg);
      rows.push_back({});
      rows.push_back({fmt::format("{}, {} poses", arm, layer.poses), "mean", "max", "RMS"});
    }
    rows.push_back({"  " + layer.layer, error_text(layer.validation.mean), error_text(layer.validation.max),
                    error_text(layer.validation.rms)});
    last = &layer;
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
  tools::ProgressLine line;
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
  const ExperimentResult result = result_of(options);
  const json::object document = experiment_document(options.experiment, result);
  const std::string text =
      options.as_json ? control::json_text(document) + "\n" : experiment_text(options.experiment, result);
  std::fputs(text.c_str(), stdout);  // first, so that a report that cannot be written costs no minutes
  if (!options.report_file.empty())
    config::write_text_file(options.report_file, report::render_experiment_html(document));
  if (worked(result)) return steering::kDone;
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
