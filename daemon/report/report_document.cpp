#include "daemon/report/report_document.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>

namespace truepose::report {
namespace {

record::CalibrationDocument read_record(const boost::json::object& document) {
  auto read = record::read_calibration_document(document);
  if (!read) throw std::invalid_argument("calibration document: " + read.error());
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

/// The values that the parameters of a simulated arm should have.
std::map<std::string, double> true_values(const record::CalibrationDocument& document) {
  CalibratedCell cell;
  cell.base = document.truth->base;
  for (const auto& [a_mm, alpha_rad, d_mm, theta_rad, beta_rad] : document.truth->links)
    cell.robot.joints.push_back(
        {.a_mm = a_mm, .alpha_rad = alpha_rad, .d_mm = d_mm, .theta_rad = theta_rad, .beta_rad = beta_rad});
  for (const IdentifiedParameter& parameter : document.parameters) {
    const std::string& name = parameter.name;
    if (name.starts_with("smr.") && name.ends_with(".x"))
      cell.reflectors.push_back({name.substr(4, name.size() - 6), document.truth->p_FS_mm});
  }
  const std::vector<std::string> names = parameter_names(cell);
  const Eigen::VectorXd values = parameter_values(cell);
  std::map<std::string, double> result;
  for (std::size_t i = 0; i < names.size(); ++i)
    result.emplace(names[i], values[static_cast<Eigen::Index>(i)]);
  return result;
}

/// The chosen first, the most useful at the top. A group's error is that with it added to the chosen ones, or
/// taken from them if it is one.
std::vector<LayerChoice> layers_of(const DeviationChoice& choice) {
  std::vector<LayerChoice> layers;
  for (const DeviationGain& group : choice.gains)
    layers.push_back({.name = group.name,
                      .chosen = group.chosen,
                      .without_mm = group.chosen ? group.rms_mm : choice.rms_mm,
                      .with_mm = group.chosen ? choice.rms_mm : group.rms_mm});
  std::ranges::stable_sort(layers, [](const LayerChoice& a, const LayerChoice& b) {
    if (a.chosen != b.chosen) return a.chosen;
    return a.without_mm - a.with_mm > b.without_mm - b.with_mm;
  });
  return layers;
}

}  // namespace

ReportDocument::ReportDocument(const boost::json::object& document)
    : CalibrationDocument{read_record(document)}, json{document}, all_points{report::all_points(*this)} {
  if (prior && !prior->used) prior.reset();
  // Nothing looks good that was not judged.
  if (!verdict) verdict = {{finding(FindingKind::NoVerdict, "the document has no verdict")}};
  if (truth) true_values = report::true_values(*this);
  if (non_geometric) deviation_layers = layers_of(*non_geometric);
  if (arm) nominal = arm->robot();
  if (base) X_WB = base->isometry();
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
