#include "tools/report/report_document.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <span>
#include <string_view>

#include "core/arm/joint_units.hpp"

namespace truepose::report {
namespace {

constexpr std::array<std::pair<const char*, double ErrorStatistics::*>, 5> kFigures{
    {{"mean", &ErrorStatistics::mean},
     {"max", &ErrorStatistics::max},
     {"rms", &ErrorStatistics::rms},
     {"min", &ErrorStatistics::min},
     {"std", &ErrorStatistics::std}}};
constexpr std::size_t kSpreading = 3;  // of them, the first ones

ErrorStatistics figures(const Node& node, std::size_t count) {
  ErrorStatistics result;
  for (const auto& [name, figure] : std::span{kFigures}.first(count)) result.*figure = node[name].number();
  return result;
}

AxisStatistics axis_statistics(const Node& node) {
  return {node["mean_abs"].number(), node["rms"].number(), node["max"].number()};
}

ErrorStatistics statistics(const Node& node) {
  ErrorStatistics result = figures(node, kFigures.size());
  result.x = axis_statistics(node["x"]);
  result.y = axis_statistics(node["y"]);
  result.z = axis_statistics(node["z"]);
  return result;
}

StageErrors stages(const Node& node) {
  // A mean over splits, where reflectors were not seen from every pose, has a part of a point.
  return {node["poses"].count(), static_cast<int>(std::lround(node["points"].number())),
          statistics(node["before"]), statistics(node["geometric"]), statistics(node["after"])};
}

Spread spread(const Node& node) {
  const std::string over = node["over"].text();
  if (over != "splits" && over != "folds") node["over"].fail("'splits' or 'folds'");
  return {over == "folds", node["count"].count(), figures(node["before"], kSpreading),
          figures(node["geometric"], kSpreading), figures(node["after"], kSpreading)};
}

PoseSet pose_set(const Node& node) {
  const std::string set = node.text();
  if (set != "identify" && set != "validate") node.fail("'identify' or 'validate'");
  return set == "identify" ? PoseSet::Identify : PoseSet::Validate;
}

Point point(const Node& node) {
  const Node joints = node["joints"];
  return {.pose = node["pose"].count(),
          .set = pose_set(node["set"]),
          .smr = node["smr"].text(),
          .joints = joints.exists() ? joints.numbers() : std::vector<double>{},
          .position = node["position"].optionally(&Node::vector),
          .errors = {node["before"].vector(), node["geometric"].vector(), node["after"].vector()},
          .remeasured = std::nullopt};
}

std::vector<Point> points(const Node& json) {
  std::vector<Point> result = json["points"].each_or_none(point);
  for (const Point& p : json["fold_points"].each_or_none(point)) result.push_back(p);
  for (const Node& node : json["remeasured_points"].elements_or_none()) {
    const int pose = node["pose"].count();
    const std::string smr = node["smr"].text();
    for (Point& p : result) {
      if (p.pose == pose && p.smr == smr) p.remeasured = node["error"].vector();
    }
  }
  return result;
}

/// Where the injected values are that a group of parameters should have: "base", "smr.NAME" (a reflector's
/// name may hold dots) or "link2".
std::optional<Node> truth_of_group(const Node& truth, std::string_view group) {
  if (group == "base") return truth["base"];
  if (group.starts_with("smr.")) {
    const Node smr = truth["smr"];
    return smr.exists() && smr[group.substr(4)].is_object() ? smr[group.substr(4)] : smr;
  }
  if (!group.starts_with("link")) return std::nullopt;
  std::size_t number = 0;
  std::from_chars(group.data() + 4, group.data() + group.size(), number);
  const std::vector<Node> links = truth["links"].elements_or_none();
  return number >= 1 && number <= links.size() ? std::optional{links[number - 1]} : std::nullopt;
}

std::optional<double> truth_of(const Node& truth, std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (!truth.exists() || dot == std::string_view::npos) return std::nullopt;
  const std::optional<Node> group = truth_of_group(truth, name.substr(0, dot));
  if (!group || !group->exists()) return std::nullopt;
  const Node value = (*group)[name.substr(dot + 1)];
  return value.exists() ? std::optional{value.number()} : std::nullopt;
}

Parameter parameter(const Node& node, const Node& truth) {
  const std::string name = node["name"].text();
  return {{.name = name,
           .nominal = node["nominal"].number(),
           .value = node["value"].number(),
           .sigma = node["sigma"].number(),
           .identified = node["identified"].flag(),
           .data_share = node["data_share"].number_or(0)},
          truth_of(truth, name),
          node["data_share"].exists()};
}

/// The chosen first, the most useful at the top.
LayerSelection ranked(LayerSelection selection) {
  std::ranges::stable_sort(selection.tried, [](const LayerChoice& a, const LayerChoice& b) {
    if (a.chosen != b.chosen) return a.chosen;
    return a.without_mm - a.with_mm > b.without_mm - b.with_mm;
  });
  return selection;
}

LayerSelection deviation(const Node& node) {
  const double without_mm = node["geometric_rms_mm"].number(), with_mm = node["rms_mm"].number();
  return ranked({without_mm, with_mm, node["groups"].each([with_mm](const Node& group) {
                   // Its error is that with it added to the chosen ones, or taken from them if it is one.
                   const bool chosen = group["chosen"].flag();
                   const double other_mm = group["rms_mm"].number();
                   return LayerChoice{.name = group["name"].text(),
                                      .chosen = chosen,
                                      .without_mm = chosen ? other_mm : with_mm,
                                      .with_mm = chosen ? with_mm : other_mm};
                 })});
}

LayerSelection residual(const Node& node) {
  const double without_mm = node["without_rms_mm"].number();
  const std::string chosen = node["chosen"].text();
  return ranked({without_mm, without_mm, node["tried"].each([&](const Node& kind) {
                   const std::string name = kind["name"].text();
                   return LayerChoice{name, name == chosen, without_mm, kind["rms_mm"].number(),
                                      kind["standard_error_mm"].number()};
                 })});
}

Rejected rejected(const Node& node) {
  std::string place;
  const auto add = [&place](const std::string& part) { place += (place.empty() ? "" : ", ") + part; };
  const Node pose = node["pose"];
  if (pose.exists() && pose.count() > 0) add("pose " + std::to_string(pose.count()));
  if (const std::string smr = node["smr"].text_or_empty(); !smr.empty()) add("reflector " + smr);
  if (const int row = node["row"].count(); row > 0) add("row " + std::to_string(row));
  return {place, node["residual_mm"].number(), node["sigmas"].number()};
}

Transfer transfer(const Node& node) {
  return {.rms_mm = node["rms_mm"].number(),
          .max_mm = node["max_mm"].number(),
          .worst_joints = node["worst_joints"].numbers(),
          .warning = node["warning"].text_or_empty()};
}

Joint joint(const Node& node) {
  Joint joint;
  if (node["type"].text() == "prismatic") joint.type = JointType::Prismatic;
  joint.a_mm = node["a"].number();
  joint.alpha_rad = node["alpha"].number() * kRadPerDeg;
  joint.d_mm = node["d"].number();
  joint.theta_rad = node["theta"].number() * kRadPerDeg;
  joint.beta_rad = node["beta"].number() * kRadPerDeg;
  joint.sign = node["sign"].number();
  joint.min = node["min"].number() * unit_of(joint);
  joint.max = node["max"].number() * unit_of(joint);
  return joint;
}

/// Of record::arm_document().
RobotModel arm(const Node& node) {
  RobotModel robot;
  robot.name = node["name"].text();
  const std::vector<Node> joints = node["joints"].elements();
  if (joints.size() > static_cast<std::size_t>(kMaxJoints)) node["joints"].fail("a list that short");
  for (const Node& element : joints) {
    robot.joints.push_back(joint(element));
    const Node mass = element["mass"];
    if (mass.exists()) robot.masses.push_back({mass["kg"].number(), mass.xyz()});
  }
  return robot;
}

Eigen::Isometry3d base(const Node& node) {
  const BasePose pose{node.xyz(), {node["rx"].number(), node["ry"].number(), node["rz"].number()}};
  return pose.isometry();
}

}  // namespace

ReportDocument read_document(const boost::json::object& document) {
  const Node json{document, "calibration document"};
  ReportDocument result{
      .json = json,
      .robot = json["robot"].text_or_empty(),
      .converged = json["converged"].flag(),
      .identify = stages(json["identify"]),
      .validate = json["validate"].optionally(stages),
      .remeasured = json["remeasured"].optionally(statistics),
      .spread = json["spread"].optionally(spread),
      .rank = json["rank"].count(),
      .parameters = json["parameters"].each([&](const Node& node) { return parameter(node, json["truth"]); }),
      .points = points(json),
      .deviation = json["deviation"].optionally(deviation),
      .residual = json["residual"].optionally(residual),
      .rejected = json["rejected"].each_or_none(rejected),
      .transfer = json["transfer"].optionally(transfer),
      .arm = json["arm"].optionally(arm),
      .X_WB = json["base"].optionally(base)};
  if (const Node node = json["observability"]; node.exists()) {
    result.unknown = node["unknown"].texts();
    result.weak = node["weak"].texts();
  }
  if (const Node node = json["prior"]; node.exists() && node["used"].flag())
    result.prior = {.length_mm = node["length_mm"].number(), .angle_rad = node["angle_rad"].number()};
  return result;
}

std::size_t ReportDocument::geometric_parameters() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      parameters, [](const Parameter& parameter) { return !parameter.name.starts_with("joint"); }));
}

std::vector<Point> ReportDocument::points_of(PoseSet set) const {
  std::vector<Point> result;
  std::ranges::copy_if(points, std::back_inserter(result), [set](const Point& p) { return p.set == set; });
  return result;
}

bool has_layers(const StageErrors& stages) {
  return stages.after.mean != stages.geometric.mean || stages.after.max != stages.geometric.max;
}

}  // namespace truepose::report
