#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cstdio>
#include <iostream>
#include <memory>

#include "config/model_file.hpp"
#include "config/number_text.hpp"
#include "config/test_cycle_file.hpp"
#include "config/text_file.hpp"
#include "core/judge/test_cube.hpp"
#include "proto/record/iso9283_document.hpp"
#include "tools/report/report.hpp"
#include "tools/truepose/iso9283_text.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

struct Iso9283Command {
  std::string data_file, targets_file, model_file, report_file, plane = "C1-C2-C7-C8";
  std::vector<double> cube;
  bool fit_frame = false, as_json = false;
};

/// The commanded positions of a test, as a file of targets.
void print_targets(const Iso9283Command& command) {
  TestCube cube{.edge_mm = command.cube[3]};
  cube.X_BC.translation() = Eigen::Vector3d(command.cube[0], command.cube[1], command.cube[2]);
  std::puts("point,x,y,z");
  int number = 0;
  for (const Eigen::Vector3d& p : test_positions(cube, value_of(kPlaneNames, command.plane))) {
    std::printf("P%d,%s,%s,%s\n", ++number, config::format_number(p.x()).c_str(),
                config::format_number(p.y()).c_str(), config::format_number(p.z()).c_str());
  }
}

/// What was evaluated, so that the report carries it.
std::vector<report::EmbeddedFile> embedded_files(const Iso9283Command& command) {
  std::vector<report::EmbeddedFile> files;
  const auto add = [&files](const char* name, const std::string& file, const char* type, const char* about) {
    if (!file.empty()) files.push_back({name, type, config::read_bytes(file), about});
  };
  add("cycles.csv", command.data_file, "text/csv", "the cycles, as truepose iso9283 --data reads them");
  add("targets.csv", command.targets_file, "text/csv", "the commanded poses (--targets)");
  add("model.yaml", command.model_file, "application/yaml", "the model whose base pose was used (--model)");
  return files;
}

void evaluate(const Iso9283Command& command) {
  std::vector<TestPoint> points = config::load_test_cycles(command.data_file, command.targets_file);
  record::Iso9283Frame frame = record::Iso9283Frame::AsGiven;
  if (!command.model_file.empty()) {
    frame = record::Iso9283Frame::Model;
    points =
        in_base(std::move(points), config::load_model(command.model_file).cell.base.isometry().inverse());
  } else if (command.fit_frame) {
    frame = record::Iso9283Frame::Fitted;
    const auto X_BM = fitted_frame(points);
    if (!X_BM) throw ConfigError(command.data_file + ": --fit-frame: " + X_BM.error());
    points = in_base(std::move(points), *X_BM);
  }
  const auto result = evaluate_iso9283(points);
  if (!result) throw ConfigError(command.data_file + ": " + result.error());
  const boost::json::object document = record::iso9283_document(*result, points, frame);
  if (!command.report_file.empty())
    config::write_text_file(command.report_file, report::render_iso9283_html(document, command.data_file,
                                                                             embedded_files(command)));
  if (command.as_json) {
    std::cout << document << '\n';
  } else {
    std::fputs(iso9283_text(*result, points, frame).c_str(), stdout);
  }
}

}  // namespace

void add_iso9283_command(CLI::App& app) {
  const auto command = std::make_shared<Iso9283Command>();
  CLI::App* sub = app.add_subcommand("iso9283", "Pose accuracy and repeatability by ISO 9283:1998");
  CLI::Option* data = sub->add_option(
      "--data", command->data_file,
      "Cycles (CSV: point,cycle,x,y,z in mm; optional a,b,c in deg, smr, direction, and time, the same "
      "for all rows of a series; commanded poses in cx,cy,cz,ca,cb,cc or in --targets)");
  sub->add_option("--targets", command->targets_file,
                  "Commanded poses of the measured point (CSV: point,x,y,z; optional a,b,c, smr)")
      ->needs(data);
  CLI::Option* model =
      sub->add_option("--model", command->model_file,
                      "The data are in the tracker's frame: bring them into the robot's base by "
                      "this model's base pose")
          ->needs(data);
  sub->add_flag("--fit-frame", command->fit_frame,
                "Or by a fit of the mean positions to the commanded ones, which makes AP relative")
      ->needs(data)
      ->excludes(model);
  CLI::Option* cube =
      sub->add_option("--cube", command->cube,
                      "Without data: print the five positions of a test in this cube as targets, "
                      "its edges parallel to the base")
          ->type_name("X,Y,Z,EDGE")
          ->delimiter(',')
          ->expected(4)
          ->excludes(data);
  sub->add_option("--plane", command->plane, "Diagonal plane of the cube")
      ->check(available(names_of(kPlaneNames)))
      ->needs(cube);
  sub->add_option("--report", command->report_file, "Write a report here (HTML, one file)")->needs(data);
  sub->add_flag("--json", command->as_json, "One JSON document")->needs(data);
  sub->callback([command, data, cube] {
    if (!*data && !*cube) throw CLI::RequiredError("--data or --cube");
    if (*cube) return print_targets(*command);
    evaluate(*command);
  });
}

}  // namespace truepose::tools
