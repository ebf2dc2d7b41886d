#include "tools/truepose/arm_files.hpp"

namespace truepose::tools {

config::ModelFile load_model_of(const RobotModel& nominal, const std::filesystem::path& file) {
  config::ModelFile model = config::load_model(file);
  if (model.name != nominal.name || model.cell.robot.joint_count() != nominal.joint_count()) {
    throw config::ConfigError(file.string() + ": the model of '" + model.name + "' with " +
                              std::to_string(model.cell.robot.joint_count()) +
                              " joints, but the robot file is of '" + nominal.name + "' with " +
                              std::to_string(nominal.joint_count()));
  }
  return model;
}

}  // namespace truepose::tools
