#include "tools/report/joint_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/statistics.hpp"
#include "tools/report/local_regression.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/scatter_chart.hpp"

namespace truepose::report {
namespace {

// Nearer to the axis a joint hardly moves the reflector, and an error along that motion says nothing of it.
constexpr double kLeastLeverMm = 20;
// Of the joint's range: so narrow that the second harmonic of a whole turn keeps most of its height, and
// wider where few points would lead the line about.
constexpr double kNarrowest = 1.0 / 18, kWidest = 1.0 / 5, kPointsWithin = 3;
constexpr int kCurveSamples = 80;
constexpr std::size_t kFewestPlotted = 5;
constexpr double kExtentMedians =
    7;  // of the median distance from zero: more than four standard deviations of noise

/// What a stage left at one point.
using StageError = Eigen::Vector3d Point::*;

JointVector joint_positions(const RobotModel& arm, const Point& point) {
  return joints_from(point.joints, arm);
}

/// In which direction each joint moves the reflector, unit length in the tracker's frame; none where it
/// hardly does.
std::vector<std::optional<Eigen::Vector3d>> motions(const Setup& setup, const Point& point) {
  const RobotModel& arm = *setup.arm;
  LinkFrames X_B;
  link_frames(arm.joints, joint_positions(arm, point), X_B);
  const Eigen::Vector3d p_B = setup.X_WB->inverse() * *point.position;
  std::vector<std::optional<Eigen::Vector3d>> result;
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const Eigen::Isometry3d& frame = X_B[i + 1];
    const Eigen::Vector3d axis = arm.joints[i].sign * frame.linear().col(2);
    if (arm.joints[i].type == JointType::Prismatic) {
      result.emplace_back(setup.X_WB->linear() * axis);
      continue;
    }
    const Eigen::Vector3d motion = axis.cross(p_B - frame.translation());
    result.push_back(motion.norm() < kLeastLeverMm
                         ? std::nullopt
                         : std::optional<Eigen::Vector3d>(setup.X_WB->linear() * motion.normalized()));
  }
  return result;
}

struct Stage {
  std::string name;
  std::string_view color;
  StageError error;
};

std::vector<Stage> stages(const ReportDocument& document) {
  std::vector<Stage> result{{"Geometric", kGeometricColor, &Point::geometric}};
  if (has_layers(document.judged())) result.push_back({"All layers", kLayersColor, &Point::after});
  return result;
}

/// Every chart of one height, so that joints compare; the few points beyond it lie on its edge.
double extent_of(const std::vector<ScatterChart>& charts) {
  std::vector<double> sizes;
  for (const ScatterChart& chart : charts) {
    for (const Series& series : chart.series) {
      for (const ChartPoint& p : series.points) sizes.push_back(std::abs(p.y));
    }
  }
  const double extent = std::min(std::ranges::max(sizes), kExtentMedians * median(sizes));
  return extent > 0 ? extent : 1;
}

bool usable(const ReportDocument& document, const std::vector<Point>& points) {
  const Setup& setup = document.setup;
  return setup.arm && setup.X_WB && !points.empty() && std::ranges::all_of(points, [&](const Point& p) {
           return p.position && p.joints.size() == setup.arm->joints.size();
         });
}

std::vector<ScatterChart> charts_of(const ReportDocument& document, const std::vector<Point>& points) {
  const std::vector<Joint>& joints = document.setup.arm->joints;
  std::vector<ScatterChart> charts;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    ScatterChart chart{.title = fmt::format("Joint {}, mm", i + 1),
                       .x_label = std::string{unit_name(joints[i])},
                       .series = {},
                       .curves = {}};
    for (const Stage& stage : stages(document)) {
      chart.series.push_back({stage.name, std::string(stage.color), Marker::Circle, {}});
    }
    charts.push_back(std::move(chart));
  }
  for (const Point& point : points) {
    const auto directions = motions(document.setup, point);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (!directions[i]) continue;
      std::size_t k = 0;
      for (const Stage& stage : stages(document)) {
        const double along = (point.*stage.error).dot(*directions[i]);
        charts[i].series[k++].points.push_back(
            {point.joints[i], along,
             fmt::format("Pose {}, reflector {}: {} mm", point.pose, point.smr, error_text(along))});
      }
    }
  }
  return charts;
}

void add_curves(ScatterChart& chart) {
  for (const Series& series : chart.series) {
    std::vector<std::pair<double, double>> points;
    for (const ChartPoint& p : series.points) points.emplace_back(p.x, p.y);
    const auto [lo, hi] = std::ranges::minmax(points, {}, &std::pair<double, double>::first);
    const double part = std::clamp(kPointsWithin / static_cast<double>(points.size()), kNarrowest, kWidest);
    const double bandwidth = std::max((hi.first - lo.first) * part, 1e-9);
    chart.curves.push_back(local_regression(points, bandwidth, kCurveSamples));
  }
}

}  // namespace

std::string joint_section(const ReportDocument& document) {
  const std::vector<Point> points = document.judged_points();
  if (!usable(document, points)) return "";
  std::vector<ScatterChart> charts = charts_of(document, points);
  std::erase_if(
      charts, [](const ScatterChart& chart) { return chart.series.front().points.size() < kFewestPlotted; });
  if (charts.empty()) return "";
  std::string html = fmt::format(
      "<section class=\"whole\">\n<h2>What is left, joint by joint</h2>\n<p class=\"note\">The part of each "
      "error that lies along the motion of the joint, over its position: {} points. A wave in the smooth "
      "line "
      "is an error that turns with the joint, such as that of a gear; a flat one says that nothing of the "
      "kind "
      "is left. The few points beyond the scale lie on its edge. A joint that hardly moves the reflector is "
      "left out.</p>\n<p class=\"key-line\">",
      document.validate ? "validation" : "identification");
  for (const Stage& stage : stages(document)) {
    html += fmt::format("<span class=\"key\" style=\"background: {}\"></span>{} ", stage.color, stage.name);
  }
  html += "</p>\n<div class=\"charts three\">\n";
  const double extent = extent_of(charts);
  for (ScatterChart& chart : charts) {
    chart.y_extent = extent;
    add_curves(chart);
    html += scatter_chart_svg(chart);
  }
  return html + "</div>\n</section>\n";
}

}  // namespace truepose::report
