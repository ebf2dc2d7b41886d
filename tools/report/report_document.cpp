#include "tools/report/report_document.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>

#include "tools/report/json_node.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

AxisStatistics axis_statistics(const Node& node) {
  return {node.find("mean_abs").number(), node.find("rms").number(), node.find("max").number()};
}

ErrorStatistics statistics(const Node& node, int points) {
  return {.count = points,
          .mean = node.find("mean").number(),
          .rms = node.find("rms").number(),
          .max = node.find("max").number(),
          .min = node.find("min").number(),
          .std = node.find("std").number(),
          .x = axis_statistics(node.find("x")),
          .y = axis_statistics(node.find("y")),
          .z = axis_statistics(node.find("z"))};
}

Stages stages(const Node& node) {
  Stages result;
  result.poses = node.find("poses").count();
  // A mean over splits, where reflectors were not seen from every pose.
  result.points = static_cast<int>(std::lround(node.find("points").number()));
  result.before = statistics(node.find("before"), result.points);
  result.geometric = statistics(node.find("geometric"), result.points);
  result.after = statistics(node.find("after"), result.points);
  return result;
}

PoseSet pose_set(const Node& node) {
  const std::string set = node.text();
  if (set != "identify" && set != "validate") node.fail("'identify' or 'validate'");
  return set == "identify" ? PoseSet::Identify : PoseSet::Validate;
}

Point point(const Node& node) {
  const Node joints = node.find("joints"), position = node.find("position");
  return {.pose = node.find("pose").count(),
          .set = pose_set(node.find("set")),
          .smr = node.find("smr").text(),
          .joints = joints.exists() ? joints.numbers() : std::vector<double>{},
          .position = position.exists() ? std::optional{position.vector()} : std::nullopt,
          .before = node.find("before").vector(),
          .geometric = node.find("geometric").vector(),
          .after = node.find("after").vector(),
          .remeasured = std::nullopt};
}

Stream stream(const Node& node) {
  const Node turnaround = node.find("turnaround_us");
  const auto count = [&](const char* key,
                         long long otherwise) {  // documents stored before have no such count
    const Node counted = node.find(key);
    return counted.exists() ? counted.integer() : otherwise;
  };
  return {.cycles = node.find("cycles").integer(),
          .answered = node.find("answered").integer(),
          .late = node.find("late").integer(),
          .wrong_ipoc = node.find("wrong_ipoc").integer(),
          .unproven = count("unproven", 0),
          .sessions = count("sessions", 1),
          .max_step_deg = node.find("max_step_deg").number(),
          .p50_us = turnaround.find("p50").number(),
          .p99_us = turnaround.find("p99").number(),
          .p999_us = turnaround.find("p999").number(),
          .max_us = turnaround.find("max").number()};
}

/// The injected value of a parameter by its name: "base.x", "smr.NAME.x" (a reflector's name may hold dots),
/// "link2.a".
std::optional<double> truth_of(const Node& truth, std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::string_view group = name.substr(0, dot);
  Node owner{nullptr, ""};
  if (group == "base") {
    owner = truth.find("base");
  } else if (group.starts_with("smr.")) {
    owner = truth.find("smr");
    if (owner.exists() && owner.find(group.substr(4)).is_object()) owner = owner.find(group.substr(4));
  } else if (group.starts_with("link") && truth.find("links").exists()) {
    std::size_t number = 0;
    std::from_chars(group.data() + 4, group.data() + group.size(), number);
    const std::vector<Node> links = truth.find("links").elements();
    if (number >= 1 && number <= links.size()) owner = links[number - 1];
  }
  if (!owner.exists()) return std::nullopt;
  const Node value = owner.find(name.substr(dot + 1));
  return value.exists() ? std::optional{value.number()} : std::nullopt;
}

Parameter parameter(const Node& node, const Node& truth) {
  Parameter result{{.name = node.find("name").text(),
                    .nominal = node.find("nominal").number(),
                    .value = node.find("value").number(),
                    .sigma = node.find("sigma").number(),
                    .identified = node.find("identified").flag()},
                   std::nullopt,
                   std::nullopt};
  if (const Node share = node.find("data_share"); share.exists()) result.data_share = share.number();
  if (truth.exists()) result.truth = truth_of(truth, result.identified.name);
  return result;
}

void add_remeasured(std::vector<Point>& points, const Node& node) {
  const int pose = node.find("pose").count();
  const std::string smr = node.find("smr").text();
  for (Point& p : points) {
    if (p.pose == pose && p.smr == smr) p.remeasured = node.find("error").vector();
  }
}

std::string optional_text(const Node& node) { return node.exists() ? node.text() : std::string(); }

}  // namespace

ReportDocument read_document(const json::object& document) {
  const auto member = [&](std::string_view key) { return Node{document.if_contains(key), std::string(key)}; };
  ReportDocument result;
  result.robot = optional_text(member("robot"));
  result.tracker = optional_text(member("tracker"));
  result.campaign = optional_text(member("campaign"));
  result.model = optional_text(member("model"));
  result.date = optional_text(member("date"));
  result.method = member("method").text();
  result.converged = member("converged").flag();
  result.coarse_iterations = member("iterations").find("coarse").count();
  result.fine_iterations = member("iterations").find("fine").count();
  result.elapsed_s = member("elapsed_s").number();
  result.identify = stages(member("identify"));
  if (const Node node = member("validate"); node.exists()) result.validate = stages(node);
  if (const Node node = member("remeasured"); node.exists()) {
    result.remeasured = statistics(node, result.judged().points);
  }
  result.rank = member("rank").count();
  result.condition = member("condition").number();
  for (const Node& node : member("parameters").elements()) {
    result.parameters.push_back(parameter(node, member("truth")));
  }
  if (member("points").exists()) {
    for (const Node& node : member("points").elements()) result.points.push_back(point(node));
  }
  if (member("fold_points").exists()) {
    for (const Node& node : member("fold_points").elements()) result.points.push_back(point(node));
  }
  if (member("remeasured_points").exists()) {
    for (const Node& node : member("remeasured_points").elements()) add_remeasured(result.points, node);
  }
  if (const Node node = member("stream"); node.exists()) result.stream = stream(node);
  result.findings = read_findings(document);
  result.setup = read_setup(document);
  return result;
}

std::size_t ReportDocument::geometric_parameters() const {
  return static_cast<std::size_t>(std::ranges::count_if(parameters, [](const Parameter& parameter) {
    return !parameter.identified.name.starts_with("joint");
  }));
}

std::vector<Point> ReportDocument::judged_points() const {
  const PoseSet set = validate ? PoseSet::Validate : PoseSet::Identify;
  std::vector<Point> result;
  std::ranges::copy_if(points, std::back_inserter(result), [set](const Point& p) { return p.set == set; });
  return result;
}

bool has_layers(const Stages& stages) {
  return stages.after.mean != stages.geometric.mean || stages.after.max != stages.geometric.max;
}

}  // namespace truepose::report
