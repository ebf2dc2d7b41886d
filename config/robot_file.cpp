#include "config/robot_file.hpp"

#include <algorithm>

#include "config/document_kind.hpp"
#include "config/robot_library.hpp"
#include "config/yaml_layout.hpp"

namespace truepose::config {

/// A value whose record is read later.
struct Unread {
  void read(const Io& io, std::optional<YamlValue>& x) const { x = yaml_value(io); }
};

/// A robot file as it stands there; mm, deg, deg/s, kg.
struct RobotText {
  struct Link {
    Joint joint;
    std::optional<LinkMass> mass;
    std::optional<YamlValue> body;
  };
  std::string name;
  std::vector<Link> joints;
  std::vector<JointCoupling> coupling;
  Eigen::Isometry3d X_flange = Eigen::Isometry3d::Identity();
  std::optional<YamlValue> payload;
  Eigen::Vector3d gravity_B{0, 0, -1};
  std::optional<YamlValue> base_body;
};

void layout(Io& io, RobotText::Link& x) {
  layout_in_deg(io, x.joint);
  io.defaulted("acceleration", x.joint.acceleration, InUnit{unit_of(x.joint)}, Range{0, 100'000});
  io.optional("mass", x.mass);
  io.optional("body", x.body, Unread{});
}
void check(const Io& io, const RobotText::Link& x) {
  if (x.joint.min >= x.joint.max) io.fail_at("min", "expected less than max");
  if (x.joint.speed == 0) io.fail_at("speed", "expected more than 0");
}

struct LinkCount {
  std::string fault(const std::vector<RobotText::Link>& links) const {
    if (!links.empty() && links.size() <= kMaxJoints) return {};
    return "expected 1.." + std::to_string(kMaxJoints) + " joints, found " + std::to_string(links.size());
  }
};

void layout(Io& io, RobotText& x) {
  io("name", x.name);
  io("joints", x.joints, LinkCount{});
  io.optional("coupling", x.coupling, Couplings::of(x.joints));
  io.optional("flange", x.X_flange, KukaPose{});
  io.optional("payload", x.payload, Unread{});
  io.optional("gravity", x.gravity_B, Direction{});
  io.optional("base_body", x.base_body, Unread{});
}
/// One mass per joint, or none at all.
void check(const Io& io, const RobotText& x) {
  const auto has_mass = [](const RobotText::Link& link) { return link.mass.has_value(); };
  const auto without = std::ranges::find_if_not(x.joints, has_mass);
  if (without == x.joints.end() || std::ranges::none_of(x.joints, has_mass)) return;
  io.fail_at("joints", static_cast<std::size_t>(without - x.joints.begin()),
             "missing key 'mass': give one to every joint or to none");
}

namespace {

RobotText read_robot(const YamlValue& yaml) {
  expect_kind(yaml, DocumentKind::Robot);
  RobotText text;
  read_value(yaml, text);
  return text;
}

void add_parts(std::vector<BodyPart>& body, int link, const std::optional<YamlValue>& value) {
  std::vector<Capsule> capsules;
  if (value) read_value(*value, capsules);
  for (const Capsule& capsule : capsules) body.push_back({link, capsule});
}

}  // namespace

void add_payload(RobotModel& robot, const YamlValue& value) {
  if (robot.masses.empty()) value.fail("expected a mass for every joint too");
  read_value(value, robot.payload.emplace());
}

namespace {

RobotModel robot_of(const RobotText& text) {
  RobotModel robot;
  robot.name = text.name;
  robot.X_flange = text.X_flange;
  robot.coupling = text.coupling;
  robot.gravity_B = text.gravity_B;
  for (const RobotText::Link& link : text.joints) {
    robot.joints.push_back(link.joint);
    if (link.mass) robot.masses.push_back(*link.mass);
  }
  if (text.payload) add_payload(robot, *text.payload);
  return robot;
}

}  // namespace

RobotModel load_robot(const std::filesystem::path& file) { return robot_of(read_robot(read_yaml(robot_file_of(file)))); }

RobotModel parse_robot(const std::string& text, const std::string& file_name) {
  return robot_of(read_robot(parse_yaml(text, file_name)));
}

std::vector<BodyPart> load_body(const std::filesystem::path& file) {
  const RobotText text = read_robot(read_yaml(robot_file_of(file)));
  std::vector<BodyPart> body;
  add_parts(body, 0, text.base_body);
  int link = 0;
  for (const RobotText::Link& each : text.joints) add_parts(body, ++link, each.body);
  return body;
}

}  // namespace truepose::config
