#include <CLI/CLI.hpp>
#include <memory>

#include "config/model_export.hpp"
#include "config/model_file.hpp"
#include "config/text_file.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {

namespace {

struct ExportOptions {
  std::string model_file, urdf_file, csv_file;
};

void run_export(const ExportOptions& options) {
  const config::ModelFile model = config::load_model(options.model_file);
  const RobotModel& robot = model.cell.robot;
  if (!options.urdf_file.empty()) config::write_text_file(options.urdf_file, config::urdf(robot));
  if (!options.csv_file.empty())
    config::write_text_file(options.csv_file, config::parameter_csv(model.parameters, robot));
}

}  // namespace

void add_export_command(CLI::App& app) {
  const auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "Writes a calibrated arm for other programs");
  command->add_option("--model", options->model_file, "Model file of the calibrated arm")->required();
  command->add_option("--urdf", options->urdf_file,
                      "Kinematics (URDF); deviations of joints and a residual field do not fit into it");
  command->add_option("--csv", options->csv_file,
                      "Every parameter with its unit, sigma and share of the data");
  command->callback([options] {
    if (options->urdf_file.empty() && options->csv_file.empty())
      throw CLI::ValidationError("export needs --urdf or --csv");
    run_export(*options);
  });
}

}  // namespace truepose::tools
