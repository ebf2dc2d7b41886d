#include "tools/report/report_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "core/math/statistics.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

/// The errors of one stage, each with the running number of its point.
struct StageSeries {
  std::string name;
  std::string_view color;
  Marker marker;
  std::vector<std::pair<std::size_t, Eigen::Vector3d>> errors;
};

std::vector<Point> points_of(const ReportDocument& document, PoseSet set) {
  std::vector<Point> result;
  std::copy_if(document.points.begin(), document.points.end(), std::back_inserter(result),
               [set](const Point& p) { return p.set == set; });
  return result;
}

std::vector<StageSeries> stage_series(const std::vector<Point>& points, bool layers) {
  StageSeries before{"Before", kBeforeColor, Marker::HollowCircle, {}};
  StageSeries geometric{"Geometric", kGeometricColor, Marker::Circle, {}};
  StageSeries after{"All layers", kLayersColor, Marker::Circle, {}};
  StageSeries remeasured{"Compensated, re-measured", kCompensatedColor, Marker::Diamond, {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    before.errors.emplace_back(i, points[i].before);
    geometric.errors.emplace_back(i, points[i].geometric);
    if (layers) after.errors.emplace_back(i, points[i].after);
    if (points[i].remeasured) remeasured.errors.emplace_back(i, *points[i].remeasured);
  }
  std::vector<StageSeries> result;
  for (StageSeries* stage : {&before, &geometric, &after, &remeasured}) {
    if (!stage->errors.empty()) result.push_back(std::move(*stage));
  }
  return result;
}

/// What one chart shows of an error vector: its length (-1) or a coordinate (0, 1, 2).
double component(const Eigen::Vector3d& error, int axis) { return axis < 0 ? error.norm() : error[axis]; }

/// Lengths that lie more than a decade apart are readable side by side only on a logarithmic axis.
bool needs_log(const std::vector<StageSeries>& stages) {
  double lo = 1e300, hi = 0;
  for (const StageSeries& stage : stages) {
    for (const auto& [i, error] : stage.errors) {
      if (error.norm() > 0) lo = std::min(lo, error.norm());
      hi = std::max(hi, error.norm());
    }
  }
  return hi > 20 * lo;
}

/// What the enlarged charts show whole: gross errors would make all others a line. 0 where all is within it.
double enlarged_limit(const std::vector<StageSeries>& stages) {
  constexpr double kMedians = 10;
  double usual = 0, largest = 0;
  for (const StageSeries& stage : stages) {
    std::vector<double> lengths;
    for (const auto& [i, error] : stage.errors) lengths.push_back(error.norm());
    usual = std::max(usual, median(lengths));
    largest = std::max(largest, std::ranges::max(lengths));
  }
  return largest > kMedians * usual ? kMedians * usual : 0;
}

std::string four_charts(const std::vector<Point>& points, const std::vector<StageSeries>& stages,
                        bool log_length, double y_limit = 0) {
  static constexpr std::array kNames{"3-D error", "Error along x", "Error along y", "Error along z"};
  std::string html = "<div class=\"charts\">\n";
  for (int axis = -1; axis < 3; ++axis) {
    const bool log_y = axis < 0 && log_length;
    PointChart chart{.title = kNames[static_cast<std::size_t>(axis + 1)],
                     .x_label = "measured point",
                     .y_unit = log_y ? "mm, logarithmic" : "mm",
                     .y_limit = y_limit,
                     .log_y = log_y,
                     .series = {}};
    for (const StageSeries& stage : stages) {
      Series series{stage.name, std::string(stage.color), stage.marker, {}};
      for (const auto& [i, error] : stage.errors) {
        const double value = component(error, axis);
        series.points.push_back({static_cast<double>(i + 1), value,
                                 fmt::format("Pose {}, reflector {}. {}: {} mm", points[i].pose,
                                             points[i].smr, stage.name, error_text(value))});
      }
      chart.series.push_back(std::move(series));
    }
    html += point_chart_svg(chart);
  }
  return html + "</div>\n";
}

std::string set_section(const std::vector<Point>& points, const Stages& errors, std::string_view title,
                        std::string_view lead) {
  if (points.empty()) return "";
  const std::vector<StageSeries> stages = stage_series(points, has_layers(errors));
  const std::vector<StageSeries> remaining(stages.begin() + 1, stages.end());
  const double limit = enlarged_limit(remaining);
  return fmt::format("<section class=\"points\">\n<h2>{}</h2>\n<p class=\"note\">{}</p>\n", title, lead) +
         four_charts(points, stages, needs_log(stages)) +
         fmt::format("<h3>What remains after the calibration, enlarged{}</h3>\n",
                     limit > 0 ? "; what is beyond the scale lies on its edge" : "") +
         four_charts(points, remaining, false, limit) + "</section>\n";
}

}  // namespace

std::string histogram_section(const ReportDocument& document) {
  const std::vector<Point> points = document.judged_points();
  if (points.empty()) return "";
  std::string html = fmt::format(
      "<section class=\"whole\">\n<h2>How the errors are spread</h2>\n<p class=\"note\">Number of {} points "
      "with a 3-D error "
      "of each size. Every stage has its own scale.</p>\n<div class=\"charts three\">\n",
      document.validate ? "validation" : "identification");
  for (const StageSeries& stage : stage_series(points, has_layers(document.judged()))) {
    HistogramChart chart{
        .title = stage.name, .x_label = "3-D error, mm", .color = std::string(stage.color), .values = {}};
    for (const auto& [i, error] : stage.errors) chart.values.push_back(error.norm());
    if (const double limit = enlarged_limit({stage}); limit > 0) {
      for (double& value : chart.values) value = std::min(value, limit);
      chart.x_label += ", in the last bar and above";
    }
    html += histogram_svg(chart);
  }
  return html + "</div>\n</section>\n";
}

std::string point_sections(const ReportDocument& document) {
  constexpr std::string_view kSign = "Errors are predicted minus measured, in the tracker's frame.";
  // With several splits, the points are those of the first.
  const std::string_view split =
      document.findings.spread && !document.cross_validated() ? " in the first split" : "";
  std::string html;
  if (document.validate) {
    html += set_section(
        points_of(document, PoseSet::Validate), *document.validate, "Validation points",
        document.cross_validated()
            ? fmt::format("Every point as the fit predicts it that had not seen its pose. {}", kSign)
            : fmt::format("These points took no part in the identification{}. {}", split, kSign));
  }
  return html + set_section(points_of(document, PoseSet::Identify), document.identify,
                            "Identification points",
                            fmt::format("The points that the parameters were fitted to{}. {}", split, kSign));
}

}  // namespace truepose::report
