#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/math/statistics.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

void add_rows(Table& table, const ReportDocument& document, PoseSet set) {
  const StageErrors& of_set = document.errors_of(set);
  table.group(fmt::format("{}: {} poses, {} points",
                          set == PoseSet::Validate ? "Validation" : "Identification", of_set.poses,
                          of_set.points));
  for (const Stage& stage : stages_of(document, set)) {
    std::vector<std::string> cells;
    for (const Figure& figure : kFigures) {
      cells.push_back(error_text(figure.of(*stage.errors)));
      if (stage.spread && figure.spread)
        cells.back() +=
            fmt::format(" <span class=\"spread\">± {}</span>", error_text(stage.spread->*figure.spread));
    }
    const bool before = stage.errors == &of_set.before;
    cells.push_back(before ? "" : factor_text(of_set.before.mean, stage.errors->mean));
    table.row(fmt::format("{}{}", color_key(stage.color), stage.name), cells);
  }
}

/// The errors of one stage, each with the running number of its point.
struct StageSeries {
  std::string name;
  std::string_view color;
  Marker marker;
  std::vector<std::pair<std::size_t, Eigen::Vector3d>> errors = {};
};

std::vector<StageSeries> stage_series(const std::vector<Point>& points, bool layers) {
  std::vector<StageSeries> stages{{"Before", kBeforeColor, Marker::HollowCircle},
                                  {"Geometric", kGeometricColor, Marker::Circle},
                                  {"All layers", kLayersColor, Marker::Circle},
                                  {"Compensated, re-measured", kCompensatedColor, Marker::Diamond}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    stages[0].errors.emplace_back(i, points[i].before);
    stages[1].errors.emplace_back(i, points[i].geometric);
    if (layers) stages[2].errors.emplace_back(i, points[i].after);
    if (points[i].remeasured) stages[3].errors.emplace_back(i, *points[i].remeasured);
  }
  std::erase_if(stages, [](const StageSeries& stage) { return stage.errors.empty(); });
  return stages;
}

/// What one chart shows of an error vector: its length (-1) or a coordinate (0, 1, 2).
double component(const Eigen::Vector3d& error, int axis) { return axis < 0 ? error.norm() : error[axis]; }

std::vector<double> lengths_of(const StageSeries& stage) {
  std::vector<double> lengths;
  for (const auto& [i, error] : stage.errors) lengths.push_back(error.norm());
  return lengths;
}

/// Lengths that lie more than a decade apart are readable side by side only on a logarithmic axis.
bool needs_log(const std::vector<StageSeries>& stages) {
  double lo = 1e300, hi = 0;
  for (const StageSeries& stage : stages) {
    for (const double length : lengths_of(stage)) {
      if (length > 0) lo = std::min(lo, length);
      hi = std::max(hi, length);
    }
  }
  return hi > 20 * lo;
}

/// What the enlarged charts show whole: outliers would make all others a line. 0 where all is within it.
double enlarged_limit(const std::vector<StageSeries>& stages) {
  constexpr double kMedians = 10;
  double usual = 0, largest = 0;
  for (const StageSeries& stage : stages) {
    const std::vector<double> lengths = lengths_of(stage);
    usual = std::max(usual, median(lengths));
    largest = std::max(largest, std::ranges::max(lengths));
  }
  return largest > kMedians * usual ? kMedians * usual : 0;
}

std::string four_charts(const std::vector<Point>& points, const std::vector<StageSeries>& stages,
                        bool log_length, double y_limit = 0) {
  static constexpr std::array kNames{"3-D error", "Error along x", "Error along y", "Error along z"};
  std::string svgs;
  for (int axis = -1; axis < 3; ++axis) {
    const bool log_y = axis < 0 && log_length;
    PointChart chart{.title = kNames[static_cast<std::size_t>(axis + 1)],
                     .x_label = "measured point",
                     .y_unit = log_y ? "mm, logarithmic" : "mm",
                     .y_limit = y_limit,
                     .log_y = log_y,
                     .series = {}};
    for (const StageSeries& stage : stages) {
      Series series{stage.name, stage.color, stage.marker};
      for (const auto& [i, error] : stage.errors) {
        const double value = component(error, axis);
        series.points.push_back({static_cast<double>(i + 1), value,
                                 fmt::format("Pose {}, reflector {}. {}: {} mm", points[i].pose,
                                             points[i].smr, stage.name, error_text(value))});
      }
      chart.series.push_back(std::move(series));
    }
    svgs += point_chart_svg(chart);
  }
  return charts(svgs);
}

std::string set_section(const ReportDocument& document, PoseSet set, std::string_view title,
                        std::string_view lead) {
  const std::vector<Point> points = document.points_of(set);
  if (points.empty()) return "";
  const std::vector<StageSeries> stages = stage_series(points, has_layers(document.errors_of(set)));
  const std::vector<StageSeries> remaining(stages.begin() + 1, stages.end());
  const double limit = enlarged_limit(remaining);
  return section(title,
                 note(fmt::format("{} Errors are predicted minus measured, in the tracker's frame.", lead)) +
                     four_charts(points, stages, needs_log(stages)) +
                     fmt::format("<h3>Residuals after the calibration, enlarged{}</h3>\n",
                                 limit > 0 ? "; what is beyond the scale lies on its edge" : "") +
                     four_charts(points, remaining, false, limit),
                 "points");
}

}  // namespace

std::vector<Stage> stages_of(const ReportDocument& document, PoseSet set) {
  const StageErrors& errors = document.errors_of(set);
  const record::Spread* spread = set == PoseSet::Validate && document.spread ? &*document.spread : nullptr;
  std::vector<Stage> stages{
      {"Before", kBeforeColor, &errors.before, spread ? &spread->before : nullptr},
      {"Geometric", kGeometricColor, &errors.geometric, spread ? &spread->geometric : nullptr}};
  if (has_layers(errors))
    stages.push_back({"All layers", kLayersColor, &errors.after, spread ? &spread->after : nullptr});
  if (document.remeasured && set == document.judging())
    stages.push_back({"Compensated", kCompensatedColor, &*document.remeasured});
  return stages;
}

std::string statistics_section(const ReportDocument& document) {
  std::string lead =
      "<b>Before</b>: the data sheet's arm, with only the robot's base and the reflector fitted (coarse "
      "stage). <b>Geometric</b>: the identified arm (fine stage), as it predicts the measured points.";
  if (has_layers(document.judged())) lead += " <b>All layers</b>: with the models beyond geometry.";
  if (document.remeasured)
    lead += " <b>Compensated</b>: validation poses driven to with compensated joints and measured again.";
  if (document.spread) lead += fmt::format(" <b>Validation</b>: {}.", validation_text(document));
  std::vector<Column> columns{{}};
  for (const auto& [axis, name, of, spread] : kFigures) {
    const bool of_axis = name.ends_with('|'), maximum = name.starts_with("max");
    columns.push_back({maximum ? "max" : name,
                       of_axis && !maximum ? "first"
                       : name == "mean"    ? "strong"
                                           : "",
                       axis});
  }
  columns.push_back({"times better", "first"});
  Table table{"statistics", std::move(columns)};
  if (document.validate) add_rows(table, document, PoseSet::Validate);
  add_rows(table, document, PoseSet::Identify);
  return section("Position error before and after", note(lead + " All in mm.") + std::move(table).scrolled());
}

std::string turns_section(const ReportDocument& document) {
  std::string lines;
  for (const PoseSet set : {PoseSet::Validate, PoseSet::Identify}) {
    if (set == PoseSet::Validate && !document.validate) continue;
    if (const auto& turns = document.errors_of(set).orientation_errors)
      lines += note(fmt::format("{}: {}.", set == PoseSet::Validate ? "Validation" : "Identification",
                                turns_text(*turns)));
  }
  if (lines.empty()) return "";
  for (const record::MountedTarget& target : document.targets)
    lines += note(xml::escaped(mounting_text(target) + "."));
  return section("Orientation of 6-D targets, before and after", lines);
}

std::string histogram_section(const ReportDocument& document) {
  const std::vector<Point> points = document.judged_points();
  if (points.empty()) return "";
  std::string svgs;
  for (const StageSeries& stage : stage_series(points, has_layers(document.judged()))) {
    Histogram histogram{
        .title = stage.name, .x_label = "3-D error, mm", .color = stage.color, .values = lengths_of(stage)};
    if (const double limit = enlarged_limit({stage}); limit > 0) {
      for (double& value : histogram.values) value = std::min(value, limit);
      histogram.x_label += ", in the last bar and above";
    }
    svgs += histogram_svg(histogram);
  }
  return section(
      "How the errors are spread",
      note(fmt::format("Number of {} points with a 3-D error of each size. Every stage has its own "
                       "scale.",
                       document.judging_name())) +
          charts(svgs, "charts three"),
      "whole");
}

std::string point_sections(const ReportDocument& document) {
  // With several splits, the points are those of the first.
  const std::string_view split = document.spread && !document.cross_validated() ? " in the first split" : "";
  std::string html;
  if (document.validate) {
    html += set_section(document, PoseSet::Validate, "Validation points",
                        document.cross_validated()
                            ? "Every point as the fit predicts it that had not seen its pose."
                            : fmt::format("These points took no part in the identification{}.", split));
  }
  return html + set_section(document, PoseSet::Identify, "Identification points",
                            fmt::format("The points that the parameters were fitted to{}.", split));
}

std::string far_section(std::string_view title, std::string_view lead,
                        const std::vector<record::Rejected>& points) {
  if (points.empty()) return "";
  Table table{"rejected", {{}, {"error, mm"}, {"standard deviations"}}};
  for (const record::Rejected& point : points)
    table.row(xml::escaped(place_text(point)),
              {point.orientation_error_rad > 0 ? distance_text(point) : error_text(point.residual_mm),
               fmt::format("{:.0f}", point.sigmas)});
  return section(title, note(lead) + std::move(table).scrolled());
}

std::string rejected_section(const ReportDocument& document) {
  return far_section(
             "Points to identify that were left out",
             "Their error under the model that the others determine is too many standard deviations of one "
             "coordinate. Look for a wrong reflector, a moved mount or a broken beam.",
             document.rejected) +
         far_section(
             "Validation points beyond six sigma",
             "The same of points that validate. They are in the statistics of the validation all the same.",
             document.validation_outliers);
}

}  // namespace truepose::report
