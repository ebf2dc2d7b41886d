#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <iostream>
#include <memory>

#include "config/measurement_file.hpp"
#include "core/evaluation/drift_check.hpp"
#include "core/evaluation/model_noise.hpp"
#include "core/kinematics/angles.hpp"
#include "tools/truepose/arm_files.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/noise_options.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;

struct DriftCommand {
  ArmFiles arm;
  std::string data_file;
  NoiseOptions noise;
  bool as_json = false;
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

DriftReference reference_of(const DriftCommand& command, const config::ModelFile& model) {
  DriftReference reference{
      .cell = model.cell, .covariance = model.covariance, .validation_mean_mm = model.validation_mean_mm};
  if (const auto stated = noise_of(command.noise)) {
    reference.noise = *stated;
  } else if (model.noise) {
    reference.noise = *model.noise;
  } else if (model.validation_mean_mm > 0) {
    reference.noise = noise_of_mean_error(model.validation_mean_mm);
  } else {
    throw ConfigError(command.arm.model.string() +
                      ": holds no noise and was not validated: state --tracker-noise and --repeatability");
  }
  return reference;
}

std::string_view word(DriftVerdict verdict) {
  switch (verdict) {
    case DriftVerdict::Ok:
      return "ok";
    case DriftVerdict::Warning:
      return "warning";
    case DriftVerdict::Failed:
      return "failed";
  }
  return {};
}

json::array numbers(const Eigen::VectorXd& vector) { return json::array(vector.begin(), vector.end()); }

json::object cause_json(const DriftCause& cause, const CalibratedCell& cell,
                        const std::vector<Measurement>& points) {
  json::object object;
  const auto index = static_cast<std::size_t>(cause.index);
  switch (cause.kind) {
    case DriftCauseKind::Base:
      object["kind"] = "base";
      break;
    case DriftCauseKind::Reflector:
      object = {{"kind", "reflector"}, {"smr", cell.reflectors[index].name}};
      break;
    case DriftCauseKind::JointZero:
      object = {{"kind", "joint_zero"}, {"joint", cause.index + 1}};
      break;
    case DriftCauseKind::Reading:
      object = {{"kind", "reading"}, {"row", points[index].row}};
      break;
  }
  object["text"] = described(cause, cell, points);
  object["moved"] = numbers(cause.moved);
  object["sigma"] = numbers(cause.sigma);
  object["probability"] = cause.probability;
  object["explains"] = cause.explains();
  return object;
}

json::array causes_json(const std::vector<DriftCause>& causes, const CalibratedCell& cell,
                        const std::vector<Measurement>& points) {
  json::array array;
  for (const DriftCause& cause : causes) array.push_back(cause_json(cause, cell, points));
  return array;
}

json::object document(const DriftCheck& check, const config::ModelFile& model,
                      const std::vector<Measurement>& points) {
  const CalibratedCell& cell = model.cell;
  json::array errors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& e = check.errors_mm[i];
    errors.push_back(
        json::object{{"row", points[i].row}, {"x", e.x()}, {"y", e.y()}, {"z", e.z()}, {"length", e.norm()}});
  }
  return {{"verdict", word(check.verdict)},
          {"reason", check.reason},
          {"mean", check.mean_mm},
          {"max", check.max_mm},
          {"reference", check.reference_mm},
          {"distance2", check.distance2},
          {"degrees", check.degrees},
          {"probability", check.probability},
          {"parameters", model.covariance.size() > 0 ? "uncertain" : "taken as exact"},
          {"points", std::move(errors)},
          {"causes", causes_json(check.causes, cell, points)},
          {"alternatives", causes_json(check.alternatives, cell, points)}};
}

void print_check(const DriftCheck& check, const config::ModelFile& model,
                 const std::vector<Measurement>& points) {
  std::printf("  row         x         y         z     error   (mm, predicted less measured)\n");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& e = check.errors_mm[i];
    std::printf("%5d %9.3f %9.3f %9.3f %9.3f\n", points[i].row, e.x(), e.y(), e.z(), e.norm());
  }
  constexpr double kHardly = 1e-6;  // beyond, the digits say nothing
  std::printf("\nIn an unchanged cell such errors or greater have a probability %s %.2g.\n",
              check.probability < kHardly ? "below" : "of", std::max(check.probability, kHardly));
  if (model.covariance.size() == 0)
    std::printf("The model file does not say how well its parameters are known; they were taken as exact.\n");
  std::printf("%s: %s.\n", std::string(word(check.verdict)).c_str(), check.reason.c_str());
}

int run_drift(const DriftCommand& command) {
  const config::ModelFile model = load_model_of(config::load_robot(command.arm.robot), command.arm.model);
  const std::vector<Measurement> points = load_points(command.data_file, model.cell);
  const auto check = drift_check(reference_of(command, model), points);
  if (!check) throw ConfigError(command.data_file + ": " + check.error());
  if (command.as_json) {
    std::cout << document(*check, model, points) << '\n';
  } else {
    print_check(*check, model, points);
  }
  return check->verdict == DriftVerdict::Failed ? kFailed : kDone;
}

}  // namespace

void add_drift_command(CLI::App& app, int& exit_code) {
  const auto command = std::make_shared<DriftCommand>();
  CLI::App* sub = app.add_subcommand("drift", "Whether a model is still right, from about five new points");
  sub->add_option("--robot", command->arm.robot, "Robot file (YAML)")->required();
  sub->add_option("--model", command->arm.model, "Model file of the calibrated arm")->required();
  sub->add_option("--data", command->data_file,
                  "New points in the same set-up (CSV, as for calibrate, sigma not regarded): about five, "
                  "spread, all joints moved")
      ->required();
  add_noise_options(*sub, command->noise);
  sub->add_flag("--json", command->as_json, "One JSON document");
  sub->callback([=, &exit_code] { exit_code = run_drift(*command); });
}

}  // namespace truepose::tools
