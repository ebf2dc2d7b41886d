#include "config/import/urdf_file.hpp"

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>

#include "config/import/xacro_file.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_axes.hpp"
#include "core/math/angles.hpp"
#include "core/math/rounding.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::config {
namespace {

using pugi::xml_node;

constexpr double kMmPerMetre = 1000;

struct UrdfJoint {
  std::string name, type, parent, child;
  Eigen::Isometry3d X_origin = Eigen::Isometry3d::Identity();  // mm
  Eigen::Vector3d axis{1, 0, 0};
  xml_node limit;
  bool follows_another = false;
};

class Urdf {
 public:
  Urdf(const std::string& file, const pugi::xml_document& document) : file_{file} {
    const xml_node robot = document.document_element();
    name_ = robot.attribute("name").value();
    for (const xml_node link : robot.children("link"))
      links_.insert_or_assign(link.attribute("name").value(), link);
    for (const xml_node joint : robot.children("joint"))
      if (joint.child("parent")) joints_.push_back(joint_of(joint));
    if (joints_.empty())
      fail("no joint in it. Give the file that calls the macro of the arm, not the macro alone.");
    for (const UrdfJoint& joint : joints_)
      for (const std::string& link : {joint.parent, joint.child})
        if (!has_link(link)) fail(joint, "its link " + in_quotes(link) + " is not in the file. Add it.");
  }

  [[noreturn]] void fail(const std::string& what) const { throw ConfigError{file_ + ": " + what}; }
  [[noreturn]] void fail(const UrdfJoint& joint, const std::string& what) const {
    fail("joint " + in_quotes(joint.name) + ": " + what);
  }

  const std::string& name() const { return name_; }
  bool has_link(const std::string& name) const { return links_.contains(name); }
  xml_node link(const std::string& name) const { return links_.at(name); }

  const UrdfJoint* joint_to(const std::string& child) const {
    const auto found = std::ranges::find(joints_, child, &UrdfJoint::child);
    return found == joints_.end() ? nullptr : &*found;
  }
  /// The joints from the root to a link.
  std::vector<const UrdfJoint*> path_to(const std::string& link) const {
    std::vector<const UrdfJoint*> path;
    for (const UrdfJoint* joint = joint_to(link); joint != nullptr; joint = joint_to(joint->parent)) {
      if (path.size() > joints_.size()) fail(*joint, "its links form a circle");
      path.push_back(joint);
    }
    std::ranges::reverse(path);
    return path;
  }
  std::vector<std::string> roots() const {
    return links_that([this](const std::string& link) { return joint_to(link) == nullptr; });
  }
  /// The links that carry no other.
  std::vector<std::string> ends() const {
    return links_that([this](const std::string& link) {
      return std::ranges::count(joints_, link, &UrdfJoint::parent) == 0;
    });
  }

  Eigen::Vector3d triple(xml_node node, const char* attribute, const Eigen::Vector3d& standard,
                         const std::string& place) const {
    const auto given = node.attribute(attribute);
    if (!given) return standard;
    std::string_view text = given.value();
    Eigen::Vector3d v;
    for (double& each : v) {
      text = xml::trimmed(text);
      const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
      const auto number = xml::to_number<double>(text.substr(0, end));
      if (!number)
        fail(place + ": " + attribute + ": expected three numbers, found " + in_quotes(given.value()));
      each = *number;
      text.remove_prefix(end);
    }
    if (!xml::trimmed(text).empty())
      fail(place + ": " + attribute + ": expected three numbers, found " + in_quotes(given.value()));
    return v;
  }
  Eigen::Isometry3d origin(xml_node node, const std::string& place) const {
    const Eigen::Vector3d rpy = triple(node.child("origin"), "rpy", {0, 0, 0}, place);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation_zyx(rpy.z(), rpy.y(), rpy.x());
    X.translation() = triple(node.child("origin"), "xyz", {0, 0, 0}, place) * kMmPerMetre;
    return X;
  }

 private:
  UrdfJoint joint_of(xml_node node) const {
    UrdfJoint joint;
    joint.name = node.attribute("name").value();
    joint.type = node.attribute("type").value();
    joint.parent = node.child("parent").attribute("link").value();
    joint.child = node.child("child").attribute("link").value();
    const std::string place = "joint " + in_quotes(joint.name);
    joint.X_origin = origin(node, place);
    joint.axis = triple(node.child("axis"), "xyz", joint.axis, place);
    joint.limit = node.child("limit");
    joint.follows_another = static_cast<bool>(node.child("mimic"));
    return joint;
  }
  template <class Is>
  std::vector<std::string> links_that(const Is& is) const {
    std::vector<std::string> names;
    for (const auto& [name, node] : links_)
      if (is(name)) names.push_back(name);
    return names;
  }

  std::string file_, name_;
  std::map<std::string, xml_node> links_;
  std::vector<UrdfJoint> joints_;
};

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& each : names) text += (text.empty() ? "" : ", ") + each;
  return text;
}

/// The link of an option, of the usual name (a prefix in front of it is allowed), or the only candidate.
std::string chosen(const Urdf& urdf, const std::string& option, const std::string& given,
                   const std::string& usual, const std::vector<std::string>& candidates) {
  if (!given.empty()) {
    if (!urdf.has_link(given)) urdf.fail(option + ": no link " + in_quotes(given) + " in it");
    return given;
  }
  if (urdf.has_link(usual)) return usual;
  if (candidates.size() == 1) return candidates[0];
  if (candidates.empty()) urdf.fail("its links form a circle, so the arm has no base and no end");
  urdf.fail("which link is meant? Give " + option + ", one of: " + listed(candidates));
}

double rounded_limit(double value) { return std::round(value * 1000) / 1000 + 0.0; }

Joint limits_of(const Urdf& urdf, const UrdfJoint& from, std::vector<std::string>& notes) {
  Joint joint;
  if (from.type == "prismatic") {
    joint.type = JointType::Prismatic;
  } else if (from.type != "revolute" && from.type != "continuous") {
    urdf.fail(from, "a joint of type " + in_quotes(from.type) +
                        " cannot be part of the arm. Give --base and --tip.");
  }
  if (from.axis.norm() < 1e-6) urdf.fail(from, "axis: a direction of no length");
  if (from.follows_another)
    urdf.fail(from, "follows another joint (mimic), so the links are no serial chain. Give --tip.");
  const bool revolute = joint.type == JointType::Revolute;
  const auto number = [&](const char* attribute) {
    const auto given = from.limit.attribute(attribute);
    if (!given) return 0.0;
    const auto value = xml::to_number<double>(given.value());
    if (!value) urdf.fail(from, std::string{attribute} + ": not a number: " + in_quotes(given.value()));
    return revolute ? rounded_limit(*value * kDegPerRad) * kRadPerDeg : rounded_limit(*value * kMmPerMetre);
  };
  if (from.type != "continuous") {
    joint.min = number("lower");
    joint.max = number("upper");
    if (joint.min > joint.max) urdf.fail(from, "limit: lower is above upper. Correct them.");
  }
  joint.speed = number("velocity");
  const bool no_limits = !(joint.min < joint.max), no_speed = !(joint.speed > 0);
  assume_limits(joint);
  if (no_limits || no_speed)
    notes.push_back("joint " + in_quotes(from.name) + ": no " + (no_limits ? "limits" : "speed") +
                    " in the source: enter those of the data sheet");
  return joint;
}

/// The masses of the links that move with each joint, in the link frames of the rows.
void take_masses(const Urdf& urdf, const std::vector<const UrdfJoint*>& moving,
                 const std::vector<Eigen::Isometry3d>& X_links, RobotModel& robot) {
  LinkFrames X_rows;
  link_frames(robot, JointVector::Zero(robot.joint_count()), X_rows);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const std::string& name = moving[i]->child;
    const xml_node inertial = urdf.link(name).child("inertial");
    const auto kg = xml::to_number<double>(inertial.child("mass").attribute("value").value());
    if (!kg || !(*kg > 0)) urdf.fail("link " + in_quotes(name) + ": has no mass. Import without --masses.");
    const Eigen::Vector3d centre =
        X_links[i] * urdf.origin(inertial, "link " + in_quotes(name)).translation();
    const Eigen::Vector3d in_row = inverse_of(X_rows[i + 1]) * centre;
    robot.masses.push_back({*kg, (in_row * 1000).array().round() / 1000});
  }
}

}  // namespace

ImportedArm load_urdf(const std::filesystem::path& file, const UrdfOptions& options) {
  const pugi::xml_document document =
      expand_xacro(file, {.arguments = options.arguments, .keeps_masses = options.takes_masses});
  const Urdf urdf{file.string(), document};
  const std::string base = chosen(urdf, "--base", options.base, "base", urdf.roots());
  const std::string tip = chosen(urdf, "--tip", options.tip, "tool0", urdf.ends());

  std::vector<const UrdfJoint*> up = urdf.path_to(base), down = urdf.path_to(tip);
  while (!up.empty() && !down.empty() && up.front() == down.front()) {
    up.erase(up.begin());
    down.erase(down.begin());
  }
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (const UrdfJoint* joint : up) {
    if (joint->type != "fixed") urdf.fail(*joint, "moves the base " + in_quotes(base) + ". Give --base.");
    X = X * joint->X_origin;
  }
  X = inverse_of(X);
  ImportedArm arm;
  std::vector<JointAxis> axes;
  std::vector<const UrdfJoint*> moving;
  std::vector<Eigen::Isometry3d> X_links;
  for (const UrdfJoint* joint : down) {
    X = X * joint->X_origin;
    if (joint->type == "fixed") continue;
    axes.push_back(
        {limits_of(urdf, *joint, arm.notes), X.translation(), X.linear() * joint->axis.normalized()});
    moving.push_back(joint);
    X_links.push_back(X);
  }
  if (axes.empty() || axes.size() > static_cast<std::size_t>(kMaxJoints))
    urdf.fail("from " + base + " to " + tip + " there are " + std::to_string(axes.size()) +
              " joints, expected 1.." + std::to_string(kMaxJoints) + ". Give --base and --tip.");
  const ArmOfAxes rows = arm_of_axes(axes, X);
  arm.robot = rows.robot;
  arm.robot.name = urdf.name().empty() ? file.stem().string() : urdf.name();
  arm.notes.insert(arm.notes.begin(), "base: link " + base + "; flange: link " + tip);
  if (const Eigen::Vector3d p = rows.X_base.translation(); p.norm() > 0)
    arm.notes.push_back("the base frame of this file is shifted to the first axis: it stands at x " +
                        format_number(without_rounding(p.x())) + ", y " +
                        format_number(without_rounding(p.y())) + ", z " +
                        format_number(without_rounding(p.z())) + " mm of link " + base);
  if (options.takes_masses) {
    for (Eigen::Isometry3d& X_link : X_links) X_link = inverse_of(rows.X_base) * X_link;
    take_masses(urdf, moving, X_links, arm.robot);
  }
  return arm;
}

}  // namespace truepose::config
