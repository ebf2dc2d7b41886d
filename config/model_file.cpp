#include "config/model_file.hpp"

#include "config/number_text.hpp"
#include "config/ranges.hpp"
#include "config/robot_yaml.hpp"
#include "config/text_file.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "config/yaml_text.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/judge/model_noise.hpp"

namespace truepose::config {

namespace {

std::string parameter_text(const IdentifiedParameter& parameter) {
  return "  - {name: " + quoted_text(parameter.name) + ", nominal: " + format_number(parameter.nominal) +
         ", value: " + format_number(parameter.value) + ", sigma: " + format_number(parameter.sigma) +
         ", identified: " + (parameter.identified ? "true" : "false") +
         ", data_share: " + format_number(parameter.data_share) + "}\n";
}

BasePose base_value(const YamlValue& value) {
  const YamlMap map(value, {"x", "y", "z", "rx", "ry", "rz"});
  return {.p_mm = xyz_value(map, kMm),
          .rxyz_rad = {map.at("rx").number(kRad), map.at("ry").number(kRad), map.at("rz").number(kRad)}};
}

Reflector reflector_value(const YamlValue& value) {
  const YamlMap map(value, {"name", "x", "y", "z"});
  return {.name = map.at("name").text(), .p_FS_mm = xyz_value(map, kMm)};
}

IdentifiedParameter parameter_value(const YamlValue& value) {
  const YamlMap map(value, {"name", "nominal", "value", "sigma", "identified", "data_share"});
  const bool identified = map.at("identified").boolean();
  double data_share = identified ? 1 : 0;
  map.read("data_share", data_share, {0, 1});
  return {.name = map.at("name").text(),
          .nominal = map.at("nominal").number(kAny),
          .value = map.at("value").number(kAny),
          .sigma = map.at("sigma").number({0, kAny.max}),
          .identified = identified,
          .data_share = data_share};
}

std::string noise_text(const MeasurementNoise& noise) {
  return "noise: {range_mm: " + format_number(noise.tracker.range_mm) +
         ", range_mm_per_m: " + format_number(noise.tracker.range_mm_per_m) +
         ", transverse_mm: " + format_number(noise.tracker.transverse_mm) +
         ", transverse_mm_per_m: " + format_number(noise.tracker.transverse_mm_per_m) +
         ", repeatability_mm: " + format_number(noise.repeatability_mm) + "}\n";
}

MeasurementNoise model_noise_value(const YamlValue& value) {
  const YamlMap map(
      value, {"range_mm", "range_mm_per_m", "transverse_mm", "transverse_mm_per_m", "repeatability_mm"});
  const auto number = [&](std::string_view key) { return map.at(key).number({0, kMm.max}); };
  return {.tracker = {.range_mm = number("range_mm"),
                      .range_mm_per_m = number("range_mm_per_m"),
                      .transverse_mm = number("transverse_mm"),
                      .transverse_mm_per_m = number("transverse_mm_per_m")},
          .repeatability_mm = number("repeatability_mm")};
}

/// The lower triangle, row by row.
std::string covariance_text(const Eigen::MatrixXd& covariance) {
  std::string text = "covariance:\n";
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    text += "  - [";
    for (Eigen::Index j = 0; j <= i; ++j) text += (j > 0 ? ", " : "") + format_number(covariance(i, j));
    text += "]\n";
  }
  return text;
}

Eigen::MatrixXd covariance_value(const YamlValue& value, int size) {
  const std::vector<YamlValue>& rows = value.list();
  if (rows.size() != static_cast<std::size_t>(size))
    value.fail("expected a row for each of " + std::to_string(size) + " parameters");
  Eigen::MatrixXd covariance(size, size);
  for (int i = 0; i < size; ++i) {
    const YamlValue& row = rows[static_cast<std::size_t>(i)];
    if (row.list().size() != static_cast<std::size_t>(i) + 1)
      row.fail("expected " + std::to_string(i + 1) + " numbers, the lower triangle up to the diagonal");
    for (int j = 0; j <= i; ++j)
      covariance(i, j) = covariance(j, i) = row.list()[static_cast<std::size_t>(j)].number(kAny);
  }
  return covariance;
}

}  // namespace

std::optional<DriftReference> drift_reference(const ModelFile& model,
                                              const std::optional<MeasurementNoise>& stated) {
  DriftReference reference{
      .cell = model.cell, .covariance = model.covariance, .validation_mean_mm = model.validation_mean_mm};
  if (stated) {
    reference.noise = *stated;
  } else if (model.noise) {
    reference.noise = *model.noise;
  } else if (model.validation_mean_mm > 0) {
    reference.noise = noise_of_mean_error(model.validation_mean_mm);
  } else {
    return std::nullopt;
  }
  return reference;
}

std::string model_yaml(const ModelFile& model) {
  std::string text =
      "# A calibrated arm. mm, rad and kg; R = Rz(rz) Ry(ry) Rx(rx); flange: three rows of four; joints "
      "count from 1.\n";
  text += "name: " + quoted_text(model.name) + "\nserial: " + quoted_text(model.serial) +
          "\ncreated: " + quoted_text(model.created) +
          "\nvalidation_mean_mm: " + format_number(model.validation_mean_mm) + "\n";

  text += "robot:\n" + robot_text(model.cell.robot);
  const Eigen::Vector3d& angles = model.cell.base.rxyz_rad;
  text += "base: {" + xyz_text(model.cell.base.p_mm) + ", rx: " + format_number(angles.x()) +
          ", ry: " + format_number(angles.y()) + ", rz: " + format_number(angles.z()) + "}\n";
  text += model.cell.reflectors.empty() ? "reflectors: []\n" : "reflectors:\n";
  for (const Reflector& reflector : model.cell.reflectors) {
    text += "  - {name: " + quoted_text(reflector.name) + ", " + xyz_text(reflector.p_FS_mm) + "}\n";
  }
  text += model.parameters.empty() ? "parameters: []\n" : "parameters:\n";
  for (const IdentifiedParameter& parameter : model.parameters) text += parameter_text(parameter);
  if (model.noise) text += noise_text(*model.noise);
  if (model.covariance.size() > 0) text += covariance_text(model.covariance);
  return text;
}

ModelFile parse_model(const std::string& text, const std::string& file_name) {
  const YamlValue root = parse_yaml(text, file_name);
  const YamlMap map(root, {"name", "serial", "created", "validation_mean_mm", "robot", "base", "reflectors",
                           "parameters", "noise", "covariance"});
  ModelFile model;
  model.name = map.at("name").text();
  model.serial = map.at("serial").text_or_empty();
  model.created = map.at("created").text_or_empty();
  model.validation_mean_mm = map.at("validation_mean_mm").number({0, kMm.max});
  model.cell.robot = robot_value(map.at("robot"));
  model.cell.base = base_value(map.at("base"));
  for (const YamlValue& reflector : map.at("reflectors").list()) {
    model.cell.reflectors.push_back(reflector_value(reflector));
  }
  for (const YamlValue& parameter : map.at("parameters").list()) {
    model.parameters.push_back(parameter_value(parameter));
  }
  if (const YamlValue* noise = map.find("noise")) model.noise = model_noise_value(*noise);
  if (const YamlValue* covariance = map.find("covariance"))
    model.covariance = covariance_value(*covariance, ParameterLayout::of(model.cell).size());
  return model;
}

ModelFile load_model(const std::filesystem::path& file) {
  return parse_model(read_text_file(file, kMostBytesOfYaml), file.string());
}

}  // namespace truepose::config
