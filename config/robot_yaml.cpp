#include "config/robot_yaml.hpp"

#include <Eigen/Geometry>
#include <array>
#include <limits>

#include "config/field_yaml.hpp"
#include "config/joint_list.hpp"
#include "config/number_text.hpp"
#include "config/ranges.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_text.hpp"

namespace truepose::config {

namespace {

constexpr int kHighestOrder = 100'000;
constexpr double kUnit = 1e-9;  // how far a length may be from 1

struct BasisName {
  std::string_view name;
  DeviationBasis basis;
};
constexpr std::array<BasisName, 6> kBases{{{"sine", DeviationBasis::Sine},
                                           {"cosine", DeviationBasis::Cosine},
                                           {"gravity", DeviationBasis::Gravity},
                                           {"weight", DeviationBasis::Weight},
                                           {"approach", DeviationBasis::Approach},
                                           {"scale", DeviationBasis::Scale}}};

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
  add("speed", joint.speed);
  return text + "acceleration: " + format_number(joint.acceleration) + "}\n";
}

std::string term_text(const DeviationTerm& term) {
  std::string basis;
  for (const BasisName& named : kBases) {
    if (named.basis == term.basis) basis = named.name;
  }
  return "    - {joint: " + std::to_string(term.joint + 1) + ", basis: " + basis +
         ", order: " + std::to_string(term.order) + ", coefficient: " + format_number(term.coefficient) +
         "}\n";
}

/// "  key:" and a line for each element, or nothing where there is none.
template <typename Elements, typename Text>
std::string list_text(const char* key, const Elements& elements, Text text_of) {
  if (elements.empty()) return {};
  std::string text = "  " + std::string(key) + ":\n";
  for (const auto& element : elements) text += text_of(element);
  return text;
}

std::string mass_text(const LinkMass& mass) {
  return "    - {kg: " + format_number(mass.mass_kg) + ", " + xyz_text(mass.centre_mm) + "}\n";
}

Joint joint_value(const YamlValue& value) {
  const YamlMap map(
      value, {"type", "a", "alpha", "d", "theta", "beta", "sign", "min", "max", "speed", "acceleration"});
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
  map.read("acceleration", joint.acceleration, kAny);
  return joint;
}

/// Three rows of four: the rotation is kept as it is, angles would round it.
Eigen::Isometry3d isometry_value(const YamlValue& value) {
  if (value.list().size() != 12) value.fail("expected 12 numbers");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12; ++i) X(i / 4, i % 4) = value.list()[static_cast<std::size_t>(i)].number(kMm);
  if (!X.linear().isUnitary(kUnit)) value.fail("not a rotation");
  return X;
}

/// Not made a unit vector again: that would change its last digit.
Eigen::Vector3d unit_value(const YamlValue& value) {
  const Eigen::Vector3d unit = xyz_value(YamlMap(value, {"x", "y", "z"}), kMm);
  if (std::abs(unit.norm() - 1) > kUnit) value.fail("expected a direction of length 1");
  return unit;
}

DeviationBasis basis_value(const YamlValue& value) {
  std::string all;
  for (const BasisName& named : kBases) {
    if (named.name == value.text()) return named.basis;
    all += (all.empty() ? "" : ", ") + std::string(named.name);
  }
  value.fail("expected one of " + all + ", found '" + value.text() + "'");
}

DeviationTerm term_value(const YamlValue& value, int joints) {
  const YamlMap map(value, {"joint", "basis", "order", "coefficient"});
  DeviationTerm term;
  term.joint = static_cast<int>(map.at("joint").integer(1, joints)) - 1;
  term.basis = basis_value(map.at("basis"));
  const bool frame = term.basis == DeviationBasis::Weight;  // its order is a link frame's number
  map.read("order", term.order, 1, frame ? joints + 1 : kHighestOrder);
  term.coefficient = map.at("coefficient").number(kAny);
  return term;
}

/// As many as there are joints.
const YamlValue& one_per_joint(const YamlValue& list, const RobotModel& robot) {
  if (list.list().size() != robot.joints.size()) {
    list.fail("expected " + std::to_string(robot.joints.size()) + ", one per joint, found " +
              std::to_string(list.list().size()));
  }
  return list;
}

}  // namespace

std::string robot_text(const RobotModel& robot) {
  std::string text = "  name: " + quoted_text(robot.name) + "\n";
  text += list_text("joints", robot.joints, joint_text) + "  flange: [";
  for (int i = 0; i < 12; ++i) text += (i ? ", " : "") + format_number(robot.X_flange(i / 4, i % 4));
  text += "]\n  gravity: {" + xyz_text(robot.gravity_B) + "}\n";
  text += list_text("masses", robot.masses, mass_text);
  text += list_text("torque_joints", robot.torque_joints, joint_text);
  text += list_text("deviation", robot.deviation, term_text);
  if (robot.field) {
    // The only class of fields; a cast that fails rather than a field that is lost.
    const auto& field = dynamic_cast<const RegressionField&>(*robot.field);
    text += "  field:\n" + field_text(field, "    ");
  }
  return text;
}

RobotModel robot_value(const YamlValue& value) {
  const YamlMap map(value,
                    {"name", "joints", "flange", "gravity", "masses", "torque_joints", "deviation", "field"});
  RobotModel robot;
  robot.name = map.at("name").text();
  robot.joints = joints_value(map.at("joints"), joint_value);
  robot.X_flange = isometry_value(map.at("flange"));
  if (const YamlValue* gravity = map.find("gravity")) robot.gravity_B = unit_value(*gravity);
  if (const YamlValue* masses = map.find("masses")) {
    for (const YamlValue& mass : one_per_joint(*masses, robot).list()) {
      robot.masses.push_back(mass_value(mass));
    }
  }
  if (const YamlValue* joints = map.find("torque_joints")) {
    robot.torque_joints = joints_value(one_per_joint(*joints, robot), joint_value);
  }
  if (const YamlValue* terms = map.find("deviation")) {
    for (const YamlValue& term : terms->list()) {
      robot.deviation.push_back(term_value(term, robot.joint_count()));
    }
  }
  if (const YamlValue* field = map.find("field")) robot.field = field_value(*field, robot);
  return robot;
}

}  // namespace truepose::config
