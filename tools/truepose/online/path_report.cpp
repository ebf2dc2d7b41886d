#include "tools/truepose/online/path_report.hpp"

#include <string>

#include "config/path_file.hpp"
#include "config/robot_file.hpp"
#include "daemon/report/report.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/online/report_output.hpp"

namespace truepose::tools {
namespace {

config::PathFrame frame_of(const std::filesystem::path& robot, const std::filesystem::path& model_file) {
  RobotModel nominal = config::load_robot(robot);
  const config::ModelFile model = load_model_of(nominal, model_file);
  if (model.cell.reflectors.size() != 1)
    throw CommandError{kBadInput, model_file.string() + ": has " +
                                      std::to_string(model.cell.reflectors.size()) +
                                      " reflectors, and a path is of one. Give a model with one reflector."};
  return {model.cell.base.isometry(), model.cell.reflectors.front().p_FS_mm, std::move(nominal)};
}

}  // namespace

int report_path(const OnlineOptions& online, const ReportOptions& options) {
  const config::PathFrame frame = frame_of(options.robot, options.model);
  const record::ProductionDocument document{
      frame.nominal.name, options.model.string(),
      record::production_of(config::load_production_path(options.path, frame))};
  deliver({report::render_production_html(document), report::production_text(document.production),
           record::to_json(document)},
          options, online.json);
  if (std::string why = report::why_refuted(document.production); !why.empty())
    throw CommandError{kFailed, std::move(why)};
  return kDone;
}

}  // namespace truepose::tools
