#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "config/measurement_file.hpp"
#include "config/model_update.hpp"
#include "config/text_file.hpp"
#include "core/change/drift_check.hpp"
#include "core/change/drift_update.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/drift_document.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;

struct DriftCommand {
  ArmFiles arm;
  std::string data_file, out_file;
  bool update = false, activate = false;
  TableOptions table;
  NoiseOptions noise;
  OnlineOptions online;
};

/// Points of the reflectors that the model knows, by name.
std::vector<Measurement> load_points(const DriftCommand& command, const CalibratedCell& cell) {
  const std::string& file = command.data_file;
  const config::TableReading reading = reading_of(command.table);
  MeasurementData data = config::load_measurements(file, cell.robot, &reading);
  for (Measurement& point : data.points) {
    const std::string& name = data.smr_names[static_cast<std::size_t>(point.smr)];
    const auto found = std::ranges::find(cell.reflectors, name, &Reflector::name);
    if (found == cell.reflectors.end()) {
      throw ConfigError(file + ": row " + std::to_string(point.row) +
                        ": smr: the model knows no reflector '" + name + "'");
    }
    point.smr = static_cast<int>(found - cell.reflectors.begin());
  }
  return std::move(data.points);
}

int run_drift(const DriftCommand& command) {
  const config::ModelFile kept = load_model_of(config::load_robot(command.arm.robot), command.arm.model);
  const std::vector<Measurement> points = load_points(command, kept.cell);
  const config::ModelFile model = as_warm(kept, mean_temperatures_c(points), command.arm.model);
  const bool says_payload =
      std::ranges::all_of(points, [](const Measurement& point) { return point.payload.has_value(); });
  if (!says_payload)
    note_open_payload(model, command.arm.model,
                      "columns payload_kg, payload_x, payload_y and payload_z of the points say it");
  const auto reference = config::drift_reference(model, noise_of(command.noise));
  if (!reference) {
    throw ConfigError(command.arm.model.string() +
                      ": holds no noise and was not validated: state --tracker-noise and --repeatability");
  }
  const auto check = drift_check(*reference, points);
  if (!check) throw ConfigError(command.data_file + ": " + check.error());
  record::DriftDocument document = record::drift_of(*check, *reference, points);
  std::optional<DriftUpdate> update;
  if (command.update) {
    update = *update_after_drift(*reference, points);
    document.update = record::update_of(*update, points);
  }
  if (command.online.json) {
    std::cout << control::json_text(record::drift_document(document)) << '\n';
  } else {
    std::cout << drift_text(document);
  }
  if (!update || !update->doubts.empty()) return check->verdict == DriftVerdict::Failed ? kFailed : kDone;
  if (command.out_file.empty()) return kDone;
  const config::ModelFile updated =
      updated_model(model, *update, command.arm.model.filename().string() + " of " + model.created,
                    control::rfc3339(std::chrono::system_clock::now()));
  config::write_text_file(command.out_file, config::model_yaml(updated));
  if (!command.online.json) note_written({command.out_file});
  return kDone;
}

}  // namespace

Command drift_command() {
  const auto command = std::make_shared<DriftCommand>();
  DriftCommand& c = *command;
  return {
      .name = "drift",
      .help = "Whether a model is still right, from about five new points",
      .options =
          {Option("--robot", &c.arm.robot, "Robot file (YAML)",
                  {.place = "ROBOT", .needs = {"--data"}, .file = FileUse::Read}),
           Option("--model", &c.arm.model, "Model file of the calibrated arm",
                  {.place = "MODEL", .needs = {"--data"}, .file = FileUse::Read}),
           Option(
               "--data", &c.data_file,
               "New points in the same set-up (CSV, as for calibrate, sigma not regarded): about five, spread, all "
               "joints moved; without it the daemon measures them and checks its active model",
               {.place = "DATA", .needs = {"--robot", "--model"}, .file = FileUse::Read}),
           columns_option(c.table), units_option(c.table), tracker_noise_option(c.noise),
           repeatability_option(c.noise),
           Option(
               "--update", &c.update,
               "Bring base, reflectors and joint zeros up to date by the points; ends with 0 where a model that "
               "can be trusted came of it"),
           Option("--activate", &c.activate, "Let the daemon work with the updated model from then on",
                  {.needs = {"--update"}, .excludes = {"--data"}}),
           Option("--out", &c.out_file, "Write the updated model here (model file, YAML)",
                  {.needs = {"--update", "--data"}, .file = FileUse::Written}),
           Option("--daemon", &c.online.daemon, "HOST:PORT of the daemon, or the path of its control socket",
                  {.type = "HOST:PORT", .environment = "TRUEPOSE_DAEMON"}),
           Option("--token-file", &c.online.token_file, "File with the daemon's token",
                  {.environment = "TRUEPOSE_TOKEN_FILE", .file = FileUse::Read}),
           Option("--json", &c.online.json, "One JSON document")},
      .run =
          [command] {
            if (!command->data_file.empty()) return run_drift(*command);
            return check_drift(command->online, {.update = command->update, .activate = command->activate});
          },
      .method = "drift.check",
      .examples = {
          {"drift arm.yaml model.yaml five.csv", "Judge a model by five new points"},
          {"drift arm.yaml model.yaml five.csv --update -o updated.yaml", "Bring it up to date by them"},
          {"drift", "Let the daemon measure the points and judge its active model"}}};
}

}  // namespace truepose::tools
