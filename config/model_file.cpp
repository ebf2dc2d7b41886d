#include "config/model_file.hpp"

#include <Eigen/Geometry>

#include "config/joint_list.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "config/yaml_reader.hpp"

namespace truepose::config {

namespace {

// A model file comes from our own hand: bounds only keep out what no arm can be.
constexpr Range kMm{-1e6, 1e6};
constexpr Range kRad{-1e4, 1e4};
constexpr Range kAny{-1e9, 1e9};

/// Double quotes with JSON's escapes, which YAML reads too: any text comes back as it was.
std::string yaml_text(const std::string& text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') result += '\\';
    if (byte < 0x20) {
      result += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string xyz_text(const Eigen::Vector3d& v) {
  return "x: " + format_number(v.x()) + ", y: " + format_number(v.y()) + ", z: " + format_number(v.z());
}

std::string joint_text(const Joint& joint) {
  std::string text = "    - {";
  if (joint.type == JointType::Prismatic) text += "type: prismatic, ";
  const auto add = [&](const char* key, double value) {
    text += std::string(key) + ": " + format_number(value) + ", ";
  };
  add("a", joint.a_mm);
  add("alpha", joint.alpha_rad);
  add("d", joint.d_mm);
  add("theta", joint.theta_rad);
  add("beta", joint.beta_rad);
  add("sign", joint.sign);
  add("min", joint.min);
  add("max", joint.max);
  return text + "speed: " + format_number(joint.speed) + "}\n";
}

std::string parameter_text(const IdentifiedParameter& parameter) {
  return "  - {name: " + yaml_text(parameter.name) + ", nominal: " + format_number(parameter.nominal) +
         ", value: " + format_number(parameter.value) + ", sigma: " + format_number(parameter.sigma) +
         ", identified: " + (parameter.identified ? "true" : "false") + "}\n";
}

Joint joint_value(const YamlValue& value) {
  const YamlMap map(value, {"type", "a", "alpha", "d", "theta", "beta", "sign", "min", "max", "speed"});
  Joint joint;
  map.read("type", joint.type, {{"revolute", JointType::Revolute}, {"prismatic", JointType::Prismatic}});
  joint.a_mm = map.at("a").number(kMm);
  joint.alpha_rad = map.at("alpha").number(kRad);
  joint.d_mm = map.at("d").number(kMm);
  joint.theta_rad = map.at("theta").number(kRad);
  joint.beta_rad = map.at("beta").number(kRad);
  joint.sign = map.at("sign").number({-1, 1});
  joint.min = map.at("min").number(kAny);
  joint.max = map.at("max").number(kAny);
  joint.speed = map.at("speed").number(kAny);
  return joint;
}

/// Three rows of four: the rotation is kept as it is, angles would round it.
Eigen::Isometry3d isometry_value(const YamlValue& value) {
  if (value.list().size() != 12) value.fail("expected 12 numbers");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) X(i / 4, i % 4) = value.list()[static_cast<std::size_t>(i)].number(kMm);
  if (!X.linear().isUnitary(1e-9)) value.fail("not a rotation");
  return X;
}

Eigen::Vector3d xyz_value(const YamlMap& map, Range range) {
  return {map.at("x").number(range), map.at("y").number(range), map.at("z").number(range)};
}

RobotModel robot_value(const YamlValue& value) {
  const YamlMap map(value, {"name", "joints", "flange"});
  RobotModel robot;
  robot.name = map.at("name").text();
  robot.joints = joints_value(map.at("joints"), joint_value);
  robot.X_flange = isometry_value(map.at("flange"));
  return robot;
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
  const YamlMap map(value, {"name", "nominal", "value", "sigma", "identified"});
  return {.name = map.at("name").text(),
          .nominal = map.at("nominal").number(kAny),
          .value = map.at("value").number(kAny),
          .sigma = map.at("sigma").number({0, kAny.max}),
          .identified = map.at("identified").boolean()};
}

}  // namespace

std::string model_yaml(const ModelFile& model) {
  const RobotModel& robot = model.cell.robot;
  std::string text =
      "# A calibrated arm. mm and rad; R = Rz(rz) Ry(ry) Rx(rx); flange: three rows of four.\n";
  text += "name: " + yaml_text(model.name) + "\nserial: " + yaml_text(model.serial) +
          "\ncreated: " + yaml_text(model.created) +
          "\nvalidation_mean_mm: " + format_number(model.validation_mean_mm) + "\n";

  text += "robot:\n  name: " + yaml_text(robot.name) + "\n  joints:\n";
  for (const Joint& joint : robot.joints) text += joint_text(joint);
  text += "  flange: [";
  for (int i = 0; i < 12; ++i) text += (i ? ", " : "") + format_number(robot.X_flange(i / 4, i % 4));
  text += "]\n";

  const Eigen::Vector3d& angles = model.cell.base.rxyz_rad;
  text += "base: {" + xyz_text(model.cell.base.p_mm) + ", rx: " + format_number(angles.x()) +
          ", ry: " + format_number(angles.y()) + ", rz: " + format_number(angles.z()) + "}\n";
  text += model.cell.reflectors.empty() ? "reflectors: []\n" : "reflectors:\n";
  for (const Reflector& reflector : model.cell.reflectors) {
    text += "  - {name: " + yaml_text(reflector.name) + ", " + xyz_text(reflector.p_FS_mm) + "}\n";
  }
  text += model.parameters.empty() ? "parameters: []\n" : "parameters:\n";
  for (const IdentifiedParameter& parameter : model.parameters) text += parameter_text(parameter);
  return text;
}

ModelFile parse_model(const std::string& text, const std::string& file_name) {
  const YamlValue root = parse_yaml(text, file_name);
  const YamlMap map(
      root, {"name", "serial", "created", "validation_mean_mm", "robot", "base", "reflectors", "parameters"});
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
  return model;
}

ModelFile load_model(const std::filesystem::path& file) {
  return parse_model(read_text_file(file), file.string());
}

}  // namespace truepose::config
