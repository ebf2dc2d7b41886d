#include "tools/report/report_findings.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstddef>

#include "tools/report/json_node.hpp"

namespace truepose::report {
namespace {

StageSpread stage_spread(const Node& node) {
  return {node.find("mean").number(), node.find("max").number(), node.find("rms").number()};
}

Spread spread(const Node& node) {
  const std::string over = node.find("over").text();
  if (over != "splits" && over != "folds") node.find("over").fail("'splits' or 'folds'");
  return {.over = over,
          .count = node.find("count").count(),
          .before = stage_spread(node.find("before")),
          .geometric = stage_spread(node.find("geometric")),
          .after = stage_spread(node.find("after"))};
}

Deviations deviations(const Node& node) {
  Deviations result{.geometric_mm = node.find("geometric_rms_mm").number(),
                    .chosen_mm = node.find("rms_mm").number(),
                    .groups = {}};
  for (const Node& group : node.find("groups").elements()) {
    // A group's error is that with it added to the chosen ones, or taken from them if it is one of them.
    const bool chosen = group.find("chosen").flag();
    const double other_mm = group.find("rms_mm").number();
    result.groups.push_back({.name = group.find("name").text(),
                             .chosen = chosen,
                             .without_mm = chosen ? other_mm : result.chosen_mm,
                             .with_mm = chosen ? result.chosen_mm : other_mm});
  }
  return result;
}

Residual residual(const Node& node) {
  Residual result{.chosen = node.find("chosen").text(), .kinds = {}};
  for (const Node& kind : node.find("tried").elements()) {
    const std::string name = kind.find("name").text();
    result.kinds.push_back({.name = name,
                            .chosen = name == result.chosen,
                            .without_mm = node.find("without_rms_mm").number(),
                            .with_mm = kind.find("rms_mm").number(),
                            .standard_error_mm = kind.find("standard_error_mm").number()});
  }
  return result;
}

Rejected rejected(const Node& node) {
  const Node pose = node.find("pose"), smr = node.find("smr");
  return {.row = node.find("row").count(),
          .pose = pose.exists() ? pose.count() : 0,
          .smr = smr.exists() ? smr.text() : "",
          .residual_mm = node.find("residual_mm").number(),
          .sigmas = node.find("sigmas").number()};
}

Observability observability(const Node& node) {
  return {.o1 = node.find("o1").number(),
          .o2 = node.find("o2").number(),
          .o3 = node.find("o3").number(),
          .o4 = node.find("o4").number(),
          .o5 = node.find("o5").number(),
          .unknown = node.find("unknown").texts(),
          .weak = node.find("weak").texts()};
}

MapAxis map_axis(const Node& node) {
  return {.joint = node.find("joint").count(),
          .from = node.find("from").number(),
          .to = node.find("to").number(),
          .count = node.find("count").count()};
}

UncertaintyMap uncertainty_map(const Node& node) {
  UncertaintyMap map{.x = map_axis(node.find("x")),
                     .y = map_axis(node.find("y")),
                     .held = node.find("held").numbers(),
                     .sigma_mm = {}};
  const auto has = [](const std::vector<double>& row, int count) {
    return row.size() == static_cast<std::size_t>(count);
  };
  for (const Node& row : node.find("sigma_mm").elements()) {
    map.sigma_mm.push_back(row.numbers());
    if (!has(map.sigma_mm.back(), map.x.count)) row.fail("one number for each x");
  }
  if (map.sigma_mm.size() != static_cast<std::size_t>(map.y.count) || map.x.count < 2 || map.y.count < 2)
    node.find("sigma_mm").fail("an array for each y");
  for (const MapAxis& axis : {map.x, map.y}) {
    if (axis.joint < 1 || static_cast<std::size_t>(axis.joint) > map.held.size())
      node.find("held").fail("the positions of all joints");
  }
  return map;
}

Transfer transfer(const Node& node) {
  Transfer result{.rms_mm = node.find("rms_mm").number(),
                  .max_mm = node.find("max_mm").number(),
                  .worst_joints = node.find("worst_joints").numbers(),
                  .warning = {},
                  .maps = {}};
  if (const Node warning = node.find("warning"); warning.exists()) result.warning = warning.text();
  if (const Node maps = node.find("maps"); maps.exists()) {
    for (const Node& map : maps.elements()) result.maps.push_back(uncertainty_map(map));
  }
  return result;
}

MeasurementNoise noise(const Node& node) {
  const auto number = [&node](std::string_view key) {
    const Node value = node.find(key);
    return value.exists() ? value.number() : 0;
  };
  return {.tracker = {.range_mm = number("range_mm"),
                      .range_mm_per_m = number("range_mm_per_m"),
                      .transverse_mm = number("transverse_mm"),
                      .transverse_mm_per_m = number("transverse_mm_per_m")},
          .repeatability_mm = number("repeatability_mm")};
}

}  // namespace

Findings read_findings(const boost::json::object& document) {
  const auto member = [&](const char* key) { return Node{document.if_contains(key), key}; };
  Findings result;
  if (const Node node = member("spread"); node.exists()) result.spread = spread(node);
  if (const Node node = member("deviation"); node.exists()) result.deviations = deviations(node);
  if (const Node node = member("residual"); node.exists()) result.residual = residual(node);
  if (const Node node = member("rejected"); node.exists()) {
    for (const Node& point : node.elements()) result.rejected.push_back(rejected(point));
  }
  if (const Node node = member("observability"); node.exists()) result.observability = observability(node);
  if (const Node node = member("prior"); node.exists() && node.find("used").flag()) {
    result.prior = {node.find("length_mm").number(), node.find("angle_rad").number()};
  }
  if (const Node node = member("transfer"); node.exists()) result.transfer = transfer(node);
  if (const Node node = member("noise"); node.exists()) result.noise = noise(node);
  if (const Node node = member("rank_gap"); node.exists()) result.rank_gap = node.number();
  if (const Node node = member("sigma0_mm"); node.exists()) result.sigma0_mm = node.number();
  return result;
}

std::vector<LayerChoice> ranked(std::vector<LayerChoice> choices) {
  std::ranges::stable_sort(choices, [](const LayerChoice& a, const LayerChoice& b) {
    if (a.chosen != b.chosen) return a.chosen;
    return a.without_mm - a.with_mm > b.without_mm - b.with_mm;
  });
  return choices;
}

}  // namespace truepose::report
