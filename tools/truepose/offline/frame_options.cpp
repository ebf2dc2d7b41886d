#include "tools/truepose/offline/frame_options.hpp"

#include "config/number_text.hpp"
#include "core/math/angles.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

std::optional<Eigen::Isometry3d> frame_of(const FrameWords& words, const std::string& option) {
  if (words.size() == 1) return std::nullopt;
  std::vector<double> v;
  for (const std::string& word : words) {
    if (const auto number = config::parse_number(word)) v.push_back(*number);
  }
  if (v.size() != 6 || words.size() != 6)
    throw ConfigError(option + ": expected a file, or the six numbers x,y,z,a,b,c in mm and deg");
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

}  // namespace

std::optional<Tool> tool_of(const FrameWords& words, const std::string& option, const RobotModel& nominal,
                            const config::ModelFile& model) {
  if (words.empty()) return std::nullopt;
  if (const auto X = frame_of(words, option)) return Tool{.X_controller = *X, .X_FT = *X, .measured = {}};
  const config::ToolFile file = config::load_tool(words[0], nominal);
  if (!file.serial.empty() && !model.serial.empty() && file.serial != model.serial)
    throw ConfigError(words[0] + ": the tool was measured on arm " + file.serial +
                      ", but the model is of arm " + model.serial + "; measure the tool on this arm");
  const auto by =
      config::measuring_cell(model).value_or(MeasuringCell{model.cell, {}, {.repeatability_mm = 1}});
  const auto measured = config::tool_under(by, file);
  if (!measured) throw ConfigError(words[0] + ": " + measured.error());
  return Tool{file.number, file.X_controller, measured->X, *measured};
}

std::optional<Base> base_of(const FrameWords& words, const std::string& option,
                            const config::ModelFile& model) {
  if (words.empty()) return std::nullopt;
  if (const auto X = frame_of(words, option)) return Base{.X = *X, .covariance = {}};
  const config::BaseFile file = config::load_base(words[0], model);
  return Base{file.number, file.X, file.covariance};
}

MeasuringCell measuring_cell_of(const config::ModelFile& model, const std::filesystem::path& file,
                                const std::optional<MeasurementNoise>& stated) {
  auto by = config::measuring_cell(model, stated);
  if (!by)
    throw ConfigError(file.string() +
                      ": holds no noise and was not validated: state --tracker-noise and --repeatability");
  return *std::move(by);
}

}  // namespace truepose::tools
