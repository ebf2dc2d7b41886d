#include "config/import/opw_file.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "config/document_kind.hpp"
#include "config/number_text.hpp"
#include "config/yaml_reader.hpp"
#include "core/arm/joint_axes.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {
namespace {

/// rad, or deg(90).
double opw_angle(const YamlValue& value) {
  std::string text = value.text();
  const bool in_deg = text.starts_with("deg(") && text.ends_with(")");
  if (in_deg) text = text.substr(4, text.size() - 5);
  const auto number = parse_number(text);
  if (!number) value.fail(number.error());
  return in_deg ? *number * kRadPerDeg : *number;
}

}  // namespace

ImportedArm load_opw(const std::filesystem::path& file) {
  const YamlValue yaml = read_yaml(file);
  expect_kind(yaml, DocumentKind::OpwParameters);
  yaml.expect_keys({"opw_kinematics_geometric_parameters", "opw_kinematics_joint_offsets",
                    "opw_kinematics_joint_sign_corrections"});
  const YamlValue& lengths = yaml.at("opw_kinematics_geometric_parameters");
  lengths.expect_keys({"a1", "a2", "b", "c1", "c2", "c3", "c4"});
  const auto mm = [&](const char* key) { return lengths.at(key).number({-10, 10}) * 1000; };
  const double a1 = mm("a1"), a2 = mm("a2"), b = mm("b"), c1 = mm("c1"), c2 = mm("c2"), c3 = mm("c3");
  const Eigen::Vector3d wrist{a1 + a2, b, c1 + c2 + c3}, y{0, 1, 0}, z{0, 0, 1};
  const std::array<std::pair<Eigen::Vector3d, Eigen::Vector3d>, 6> lines{
      std::pair{Eigen::Vector3d{0, 0, 0}, z},
      std::pair{Eigen::Vector3d{a1, b, c1}, y},
      std::pair{Eigen::Vector3d{a1, b, c1 + c2}, y},
      std::pair{wrist, z},
      std::pair{wrist, y},
      std::pair{wrist, z}};
  std::vector<JointAxis> axes;
  for (const auto& [point, direction] : lines) {
    Joint joint;
    assume_limits(joint);
    axes.push_back({joint, point, direction});
  }
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.translation() = wrist + z * mm("c4");

  ImportedArm arm;
  arm.robot = arm_of_axes(axes, X_BF).robot;
  arm.robot.name = file.stem().string();
  arm.notes = {"no limits or speeds in the source: enter those of the data sheet"};
  const auto& offsets = yaml.at("opw_kinematics_joint_offsets").list();
  const auto& signs = yaml.at("opw_kinematics_joint_sign_corrections").list();
  if (offsets.size() != 6) yaml.at("opw_kinematics_joint_offsets").fail("expected 6 angles");
  if (signs.size() != 6) yaml.at("opw_kinematics_joint_sign_corrections").fail("expected 6 signs");
  for (std::size_t i = 0; i < 6; ++i) {
    // The parameters' angle is sign * q - offset.
    Joint& joint = arm.robot.joints[i];
    joint.theta_rad -= joint.sign * opw_angle(offsets[i]);
    if (const double sign = signs[i].number({-1, 1}); std::abs(sign) != 1) {
      signs[i].fail("expected 1 or -1");
    } else {
      joint.sign *= sign;
    }
  }
  return arm;
}

}  // namespace truepose::config
