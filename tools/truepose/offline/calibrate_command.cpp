#include <algorithm>
#include <atomic>
#include <boost/json/object.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/text_file.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/calibrate/option_names.hpp"
#include "core/compensate/largest_correction.hpp"
#include "core/data/carried_payload.hpp"
#include "core/data/measured_time.hpp"
#include "core/formatted.hpp"
#include "core/math/parallel.hpp"
#include "core/math/units.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "core/quality/joint_limits.hpp"
#include "core/quality/model_noise.hpp"
#include "daemon/report/report.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/calibration_content.hpp"
#include "proto/record/calibration_document.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/jobs_option.hpp"
#include "tools/truepose/offline/mistake_text.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/offline/validation_runs.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

struct CalibrateCommand {
  std::string robot_file, validate_file, out_file, report_file;
  std::vector<std::string> data_files;
  std::optional<double> split;
  std::optional<int> folds;
  std::optional<std::uint64_t> seed;
  int repeat = 1, jobs = processor_count();
  std::string non_geometric = "none", residual = "none", loss = "outlier-rejection", prior = "auto",
              thermal = "auto";
  std::vector<int> harmonics;  ///< empty: the usual
  TableOptions table;
  NoiseOptions noise;
  std::optional<double> tolerance_mm;
  bool is_local = false;
  bool as_json = false;
};

std::string data_names(const CalibrateCommand& command) {
  std::string names;
  for (const std::string& file : command.data_files) names += (names.empty() ? "" : ", ") + file;
  return names;
}

/// The points of all files, each from a station of its own.
MeasurementData measurements(const CalibrateCommand& command, const RobotModel& robot,
                             const config::TableReading& reading) {
  if (command.data_files.size() == 1)
    return config::load_measurements(command.data_files.front(), robot, &reading);
  MeasurementData data;
  for (const std::string& file : command.data_files) {
    MeasurementData station = config::load_measurements(file, robot, &reading);
    station.stations = {file};
    for (Measurement& point : station.points) point.pose = 0;  // unique in its own file only
    if (data.stations.empty()) {
      data = std::move(station);
    } else {
      add_station(data, std::move(station));
    }
  }
  return data;
}

/// Times of two forms have no origin in common.
void expect_times_alike(const MeasurementData& data, const MeasurementData& validation,
                        const std::string& file) {
  const auto a = measured_time(data.points.front().time), b = measured_time(validation.points.front().time);
  if (a && b && a->form != b->form)
    throw ConfigError(file + ": time: '" + validation.points.front().time +
                      "', where the data to identify have '" + data.points.front().time +
                      "': write all times in one form");
}

/// Points of another file, all to validate. Reflectors are matched by name.
void add_validation(MeasurementData& data, const CalibrateCommand& command, const RobotModel& robot,
                    const config::TableReading& reading) {
  const std::string& file = command.validate_file;
  // A point that was marked to validate is never used to identify, whatever else is given.
  std::erase_if(data.points, [](const Measurement& point) { return point.set == PoseSet::Validate; });
  MeasurementData validation = config::load_measurements(file, robot, &reading);
  if (!data.points.empty()) expect_times_alike(data, validation, file);
  std::vector<int> index_of;
  for (const std::string& name : validation.smr_names) {
    const auto found = std::ranges::find(data.smr_names, name);
    if (found == data.smr_names.end()) {
      throw ConfigError(file + ": smr: reflector '" + name + "' has no points in the data to identify");
    }
    index_of.push_back(static_cast<int>(found - data.smr_names.begin()));
  }
  for (Measurement& point : validation.points) {
    point.set = PoseSet::Validate;
    point.in_order = false;
    point.smr = index_of[static_cast<std::size_t>(point.smr)];
    data.points.push_back(std::move(point));
  }
}

CalibrateOptions options_of(const CalibrateCommand& command) {
  CalibrateOptions options;
  options.loss = value_of(kLossNames, command.loss);
  options.prior = value_of(kPriorNames, command.prior);
  options.noise = noise_of(command.noise);
  options.non_geometric = command.non_geometric == "auto";
  if (!command.harmonics.empty()) options.harmonics = command.harmonics;
  options.thermal = value_of(kThermalNames, command.thermal);
  options.field = value_of(kFieldNames, command.residual);
  return options;
}

std::string refusal(const CalibrateCommand& command, const CalibrationError& error) {
  if (!error.cause) return data_names(command) + ": " + error.detail;
  const auto station = static_cast<std::size_t>(error.cause->station);
  return mistake_text(*error.cause, command.robot_file, command.data_files[station]);
}

Outcome calibrate_once(const CalibrateCommand& command, const RobotModel& robot, const MeasurementData& data,
                       int jobs) {
  CalibrateOptions options = options_of(command);
  options.jobs = jobs;
  const auto start = std::chrono::steady_clock::now();
  auto result = calibrate(robot, data, options);
  if (!result) throw ConfigError(refusal(command, result.error()));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  record::CalibrationDocument document = record::calibration_of(*result, data, elapsed.count());
  document.noise = options.noise;
  MeasurementData fitted = as_fitted(*result, data);
  const MeasurementNoise noise = noise_about_model(*result, fitted, options.noise);
  std::vector<double> distances2 = validation_distances2(*result, fitted, noise);
  return {.calibration = std::move(*result),
          .document = std::move(document),
          .noise = noise,
          .distances2 = std::move(distances2),
          .data = std::move(fitted),
          .splits = {}};
}

CalibrationVerdict verdict_on_one(const CalibrateCommand& command, const RobotModel& robot,
                                  const Outcome& outcome, std::optional<double> tolerance_mm = {}) {
  const auto limits = measured_beyond_limits(robot, outcome.data.points);
  return calibration_verdict(
      {.calibration = outcome.calibration,
       .data = outcome.data,
       .stated = noise_of(command.noise),
       .tolerance_mm = tolerance_mm,
       .task_stated = command.is_local,
       .further_findings = limits ? std::span{&*limits, 1} : std::span<const Finding>{}});
}

CalibrationVerdict verdict_on(const CalibrateCommand& command, const RobotModel& robot,
                              const Outcome& outcome) {
  if (!outcome.splits.empty()) return verdict_over_splits(outcome.splits, command.tolerance_mm);
  return verdict_on_one(command, robot, outcome, command.tolerance_mm);
}

Outcome validated(const CalibrateCommand& command, const RobotModel& robot, MeasurementData data) {
  const int runs = command.folds ? *command.folds + 1 : command.repeat;
  std::atomic<int> done = 0;
  ProgressLine line{"calibration"};
  const auto once = [&](const MeasurementData& marked, int jobs) {
    Outcome outcome = calibrate_once(command, robot, marked, jobs);
    line.show(static_cast<double>(++done) / runs);
    return outcome;
  };
  const auto judge = [&](const Outcome& outcome) { return verdict_on_one(command, robot, outcome); };
  const std::uint64_t seed = command.seed.value_or(0);
  if (command.split)
    return over_splits(once, judge, data, {*command.split, seed, command.repeat}, command.jobs);
  if (command.folds) return over_folds(once, std::move(data), *command.folds, seed, command.jobs);
  return once(data, command.jobs);
}

/// By time alone a model is that of the warm arm.
std::optional<ThermalResponse> response_to_temperatures(const Calibration& calibration) {
  const auto& thermal = calibration.thermal;
  return thermal && !thermal->clock ? thermal->response : std::nullopt;
}

config::ModelFile model_of(const CalibrateCommand& command, const RobotModel& robot, const Outcome& outcome,
                           const CalibrationVerdict& verdict) {
  Calibration calibration = outcome.calibration;
  keep_first_station(calibration);
  const bool several = command.data_files.size() > 1;
  config::ModelFile model{.name = robot.name,
                          .serial = "",
                          .created = control::rfc3339(std::chrono::system_clock::now()),
                          .cell = calibration.cell,
                          .parameters = calibration.parameters,
                          .validation_mean_mm = calibration.validate ? calibration.validate->after.mean : 0,
                          .covariance = calibration.covariance,
                          .noise = outcome.noise,
                          .misfit_mm = calibration.misfit_mm,
                          .validation_distances2 = outcome.distances2,
                          .thermal = response_to_temperatures(calibration),
                          .verdict = verdict,
                          .station = several ? command.data_files.front() : "",
                          .validation = {}};
  model.several_payloads = !robot.payload && payload_varies(outcome.data.points);
  // Those of other stations are not in the frame of the model's base.
  if (!several) model.validation = config::validation_points(outcome.data);
  model.largest_correction_deg =
      largest_correction(robot, model.cell, config::poses_of(model.validation)) * kDegPerRad;
  return model;
}

std::string validation_text(const CalibrateCommand& command) {
  const std::string seed = ", seed " + std::to_string(command.seed.value_or(0));
  if (command.folds) return std::to_string(*command.folds) + " folds" + seed;
  if (!command.split)
    return command.validate_file.empty() ? "poses marked in the data" : "poses of a file of their own";
  const std::string percent = std::to_string(std::lround(100 * *command.split));
  return percent + " % of the poses identify, the others validate" + seed +
         (command.repeat > 1 ? " and the next " + std::to_string(command.repeat - 1) : "");
}

/// What was calibrated from what and how, for whom reads the document later.
void describe(record::CalibrationDocument& document, const CalibrateCommand& command,
              const RobotModel& robot) {
  document.robot = robot.name;
  document.date = control::rfc3339(std::chrono::system_clock::now());
  document.files = {{"Robot file", command.robot_file}, {"Measurements", data_names(command)}};
  if (!command.validate_file.empty())
    document.files.emplace_back("Measurements to validate", command.validate_file);
  document.options = record::options_in_words(options_of(command));
  document.options.insert(document.options.begin(), {"Validation", validation_text(command)});
}

void print_summary(const CalibrateCommand& command, const RobotModel& robot, const Outcome& outcome,
                   const report::ReportDocument& document) {
  const Calibration& calibration = outcome.calibration;
  std::printf("%s: %s, %d coarse and %d fine iterations, rank %d, condition %.1f\n", robot.name.c_str(),
              document.converged ? "converged" : "not converged", calibration.coarse_iterations,
              calibration.fine_iterations, calibration.rank, calibration.observability.condition());
  if (command.repeat > 1)
    std::printf("All but the validation is that of the first of %d splits.\n", command.repeat);
  std::printf("\n%s", with_shown_verdict(report::render_text(document)).c_str());
}

/// Options that would have no effect, or another than the data ask for.
void check_options(const CalibrateCommand& command) {
  if (command.seed && !command.split && !command.folds)
    throw bad_usage("--seed: requires --split or --folds. Give one of them");
  if (!command.harmonics.empty() && command.non_geometric != "auto")
    throw bad_usage("--harmonics: requires --non-geometric auto. Give both");
  if (command.data_files.size() > 1 && !command.validate_file.empty())
    throw bad_usage("--validate: does not say its station. Mark points of each --data set=validate");
}

void check_data(const CalibrateCommand& command, const MeasurementData& data) {
  const auto marked = std::ranges::find(data.points, PoseSet::Validate, &Measurement::set);
  if ((command.split || command.folds) && marked != data.points.end())
    throw ConfigError(
        command.data_files[static_cast<std::size_t>(marked->station)] + ": row " +
        std::to_string(marked->row) + ": set: validate, but " + (command.split ? "--split" : "--folds") +
        " draws the poses that validate from all rows: leave that option out, or remove the column");
  const auto has_temperature = [](const Measurement& point) { return !point.temperature_c.empty(); };
  if (value_of(kThermalNames, command.thermal) == ThermalUse::Temperatures &&
      std::ranges::none_of(data.points, has_temperature))
    throw ConfigError(data_names(command) +
                      ": no columns temp1.. with the drives' temperatures, which --thermal " +
                      command.thermal + " goes by: add them, or take auto, time or none");
}

/// No arm is as good as its data sheet: such points teach nothing.
void warn_of_own_positions(const CalibrateCommand& command, const Outcome& outcome,
                           const config::TableReading& reading) {
  constexpr double kBestArm_mm = 0.02;
  const double rms_mm = outcome.calibration.identify.before.rms;
  if (rms_mm < kBestArm_mm)
    reading.report(data_names(command) +
                   formatted(": the nominal arm fits the points to %.3f mm, which no real arm does (%.2f). "
                             "Give the tracker's readings, not the robot's own positions",
                             rms_mm, kBestArm_mm));
}

int run_calibrate(const CalibrateCommand& command) {
  check_options(command);
  const RobotModel robot = config::load_robot(command.robot_file);
  std::vector<std::string> read_as;
  config::TableReading reading = reading_of(command.table);
  reading.report = [&](const std::string& line) {
    if (!command.as_json) print_to_stderr(line);
    read_as.push_back(line);
  };
  MeasurementData data = measurements(command, robot, reading);
  check_data(command, data);
  if (!command.validate_file.empty()) add_validation(data, command, robot, reading);
  Outcome outcome = validated(command, robot, std::move(data));
  warn_of_own_positions(command, outcome, reading);
  const CalibrationVerdict verdict = verdict_on(command, robot, outcome);
  outcome.document.verdict = verdict;
  describe(outcome.document, command, robot);
  outcome.document.read_as = std::move(read_as);
  const boost::json::object json = outcome.splits.empty()
                                       ? record::calibration_document(outcome.document)
                                       : record::calibration_document_over_splits(outcome.document);
  const report::ReportDocument document{json};

  if (!command.out_file.empty()) {
    config::write_text_file(command.out_file, config::model_yaml(model_of(command, robot, outcome, verdict)));
  }
  if (!command.report_file.empty()) {
    config::write_text_file(command.report_file, report::render_html(document));
  }
  if (command.as_json) {
    std::cout << control::json_text(json) << '\n';
  } else {
    print_summary(command, robot, outcome, document);
    note_written({command.out_file, command.report_file});
  }
  if (const std::string why = report::why_unusable(document); !why.empty())
    throw CommandError{kFailed, data_names(command) + ": " + why};
  return kDone;
}

}  // namespace

Command calibrate_command() {
  const auto command = std::make_shared<CalibrateCommand>();
  CalibrateCommand& c = *command;
  return {
      .name = "calibrate",
      .help = "Identifies how a real arm differs from its data sheet",
      .options =
          {Option("--robot", &c.robot_file, "Robot file (YAML)",
                  {.required = true, .place = "ROBOT", .file = FileUse::Read}),
           Option("--data", &c.data_files,
                  "Measurements (CSV); rows marked set=validate validate. Once for each station of the "
                  "tracker; the base in --out is the one that the first sees",
                  {.required = true, .place = "DATA", .repeats = true, .file = FileUse::Read}),
           Option("--validate", &c.validate_file,
                  "Measurements that validate, in place of those marked in the data",
                  {.file = FileUse::Read}),
           Option("--split", &c.split, "Part of the poses that identify; the rest validate",
                  {.check = in_range(0.01, 0.99), .type = "SHARE", .excludes = {"--validate"}}),
           Option("--folds", &c.folds,
                  "Cross-validation: as many parts of the poses, each predicted from the others; the arm is "
                  "identified from all",
                  {.check = in_range(2, 10'000), .excludes = {"--validate", "--split"}}),
           Option("--seed", &c.seed, "Seed of the random split or folds; default: 0"),
           Option("--repeat", &c.repeat, "Splits with as many seeds, their mean and standard deviation",
                  {.check = in_range(1, 10'000), .needs = {"--split"}}),
           Option(
               "--non-geometric", &c.non_geometric,
               "Non-geometric errors of the joints (gear harmonics, compliance, backlash): those that cross-validation keeps",
               {.shows_default = true, .check = available(names_of(kNoneOrAuto))}),
           Option("--harmonics", &c.harmonics,
                  "Multiples of a joint's angle to look for, as 1,2,162; needs --non-geometric auto",
                  {.check = in_range(1, 10'000)}),
           Option(
               "--residual", &c.residual,
               "Gaussian process over what the model leaves; auto: where cross-validation shows that it helps",
               {.shows_default = true, .check = available(names_of(kFieldNames))}),
           Option(
               "--thermal", &c.thermal,
               "Source of the arm's temperatures: the columns temp1.., or the time of a campaign that began cold; "
               "auto: the columns where there are some, else time, or the order of the rows, where that "
               "shows beyond doubt",
               {.shows_default = true, .check = available(names_of(kThermalNames))}),
           Option("--loss", &c.loss,
                  "Weight of a residual; outlier-rejection: points beyond six sigma are left out",
                  {.shows_default = true, .check = available(names_of(kLossNames))}),
           Option("--prior", &c.prior, "Whether deviations from the data sheet are taken as small",
                  {.shows_default = true, .check = available(names_of(kPriorNames))}),
           columns_option(c.table),
           units_option(c.table),
           tracker_noise_option(c.noise),
           repeatability_option(c.noise),
           Option("--tolerance", &c.tolerance_mm, "Largest error that the verdict allows, mm",
                  {.check = in_range(1e-6, 1000.0), .type = "MM"}),
           Option("--local", &c.is_local,
                  "The model is used among the measured poses alone: that they are narrow is no doubt"),
           jobs_option(c.jobs),
           Option("--out", &c.out_file, "Write the calibrated arm here (model file, YAML)",
                  {.file = FileUse::Written}),
           Option("--report", &c.report_file, "Write a report here (HTML, one file)",
                  {.file = FileUse::Written}),
           Option("--json", &c.as_json, "One JSON document")},
      .run = [command] { return run_calibrate(*command); },
      .examples = {{"calibrate arm.yaml points.csv --split 0.7 -o model.yaml --report report.html",
                    "Identify from 70 % of the poses, validate on the others, write model and report"},
                   {"calibrate arm.yaml points.csv --folds 5 --tracker-noise 0.01,0.006",
                    "Validate every pose by the others; the noise is that of the tracker's data sheet"},
                   {"calibrate arm.yaml points.csv --split 0.7 --non-geometric auto --tolerance 0.2",
                    "Add compliance, gear harmonics and backlash; red where an error is above 0.2 mm"}}};
}

}  // namespace truepose::tools
