#include "daemon/report/report_document.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "daemon/report/json_node.hpp"

namespace truepose::report {
namespace {

constexpr std::string_view kKind = "calibration document";

record::CalibrationDocument read_record(const boost::json::object& document) {
  auto read = record::read_calibration_document(document);
  if (!read) throw std::invalid_argument(std::string(kKind) + ": " + read.error());
  return *std::move(read);
}

std::vector<Point> all_points(const record::CalibrationDocument& document) {
  std::vector<Point> points;
  for (const auto* list : {&document.points, &document.fold_points}) {
    for (const record::Point& point : *list) points.push_back({point, std::nullopt});
  }
  for (const record::Remeasured& again : document.remeasured_points) {
    for (Point& point : points) {
      if (point.pose == again.pose && point.smr == again.smr) point.remeasured = again.error;
    }
  }
  return points;
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

StageErrors errors_of(const record::Spread& spread) {
  const auto statistics = [](const record::StageSpread& stage) {
    return ErrorStatistics{.mean = stage.mean, .rms = stage.rms, .max = stage.max};
  };
  StageErrors errors;
  errors.before = statistics(spread.before);
  errors.geometric = statistics(spread.geometric);
  errors.after = statistics(spread.after);
  return errors;
}

/// The chosen first, the most useful at the top.
LayerSelection ranked(LayerSelection selection) {
  std::ranges::stable_sort(selection.tried, [](const LayerChoice& a, const LayerChoice& b) {
    if (a.chosen != b.chosen) return a.chosen;
    return a.without_mm - a.with_mm > b.without_mm - b.with_mm;
  });
  return selection;
}

LayerSelection layers_of(const DeviationChoice& choice) {
  LayerSelection selection{choice.geometric_rms_mm, choice.rms_mm, {}};
  // A group's error is that with it added to the chosen ones, or taken from them if it is one.
  for (const DeviationGain& group : choice.gains) {
    selection.tried.push_back({.name = group.name,
                               .chosen = group.chosen,
                               .without_mm = group.chosen ? group.rms_mm : choice.rms_mm,
                               .with_mm = group.chosen ? choice.rms_mm : group.rms_mm});
  }
  return ranked(std::move(selection));
}

/// What `f` makes of it, if it exists.
template <class T, class F>
auto optionally(const std::optional<T>& value, F f) {
  return value ? std::optional{f(*value)} : std::nullopt;
}

}  // namespace

ReportDocument read_document(const boost::json::object& document) {
  ReportDocument result{read_record(document)};
  if (result.prior && !result.prior->used) result.prior.reset();
  result.all_points = all_points(result);
  // Nothing looks good that was not judged.
  if (!result.verdict) result.verdict = {{finding(FindingKind::NoVerdict, "the document has no verdict")}};
  const Node truth = Node{document, kKind}["truth"];
  for (const IdentifiedParameter& parameter : result.parameters) {
    if (const auto value = truth_of(truth, parameter.name)) result.truth.emplace(parameter.name, *value);
  }
  result.spreads = optionally(result.spread, errors_of);
  result.deviation_layers = optionally(result.non_geometric, layers_of);
  result.nominal = optionally(result.arm, [](const record::Arm& arm) { return arm.robot(); });
  result.X_WB = optionally(result.base, [](const BasePose& base) { return base.isometry(); });
  return result;
}

std::size_t ReportDocument::geometric_parameters() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      parameters, [](const IdentifiedParameter& parameter) { return !parameter.name.starts_with("joint"); }));
}

std::vector<Point> ReportDocument::points_of(PoseSet set) const {
  std::vector<Point> result;
  std::ranges::copy_if(all_points, std::back_inserter(result),
                       [set](const Point& p) { return p.set == set; });
  return result;
}

bool has_layers(const StageErrors& stages) {
  return stages.after.mean != stages.geometric.mean || stages.after.max != stages.geometric.max;
}

}  // namespace truepose::report
