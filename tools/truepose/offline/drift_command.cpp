#include <algorithm>
#include <boost/json.hpp>
#include <iostream>
#include <memory>

#include "config/measurement_file.hpp"
#include "core/judge/drift_check.hpp"
#include "proto/record/drift_document.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/online_text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;

struct DriftCommand {
  ArmFiles arm;
  std::string data_file;
  NoiseOptions noise;
  OnlineOptions online;
};

/// Points of the reflectors that the model knows, by name.
std::vector<Measurement> load_points(const std::string& file, const CalibratedCell& cell) {
  MeasurementData data = config::load_measurements(file, cell.robot);
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
  const config::ModelFile model = load_model_of(config::load_robot(command.arm.robot), command.arm.model);
  const std::vector<Measurement> points = load_points(command.data_file, model.cell);
  const auto reference = config::drift_reference(model, noise_of(command.noise));
  if (!reference) {
    throw ConfigError(command.arm.model.string() +
                      ": holds no noise and was not validated: state --tracker-noise and --repeatability");
  }
  const auto check = drift_check(*reference, points);
  if (!check) throw ConfigError(command.data_file + ": " + check.error());
  const record::DriftDocument document = record::drift_of(*check, *reference, points);
  if (command.online.json) {
    std::cout << record::drift_document(document) << '\n';
  } else {
    std::cout << drift_text(document);
  }
  return check->verdict == DriftVerdict::Failed ? kFailed : kDone;
}

}  // namespace

Command drift_command() {
  const auto command = std::make_shared<DriftCommand>();
  DriftCommand& c = *command;
  return {
      .name = "drift",
      .help = "Whether a model is still right, from about five new points",
      .options =
          {Option(
               "--data", &c.data_file,
               "New points in the same set-up (CSV, as for calibrate, sigma not regarded): about five, spread, all "
               "joints moved; without it the daemon measures them and checks its active model",
               {.needs = {"--robot", "--model"}}),
           Option("--robot", &c.arm.robot, "Robot file (YAML)", {.needs = {"--data"}}),
           Option("--model", &c.arm.model, "Model file of the calibrated arm", {.needs = {"--data"}}),
           tracker_noise_option(c.noise), repeatability_option(c.noise),
           Option("--daemon", &c.online.daemon, "HOST:PORT of the daemon, or the path of its control socket"),
           Option("--token-file", &c.online.token_file, "file with the daemon's token",
                  {.environment = "TRUEPOSE_TOKEN_FILE"}),
           Option("--json", &c.online.json, "One JSON document")},
      .run =
          [command] {
            return command->data_file.empty() ? check_drift(command->online) : run_drift(*command);
          },
      .method = "drift.check"};
}

}  // namespace truepose::tools
