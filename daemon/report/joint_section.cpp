#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>

#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/statistics.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"

namespace truepose::report {
namespace {

// Nearer to the axis a joint hardly moves the reflector, and an error along that motion says nothing of it.
constexpr double kLeastLeverMm = 20;
constexpr std::size_t kFewestPlotted = 5;
constexpr double kExtentMedians =
    7;  // of the median distance from zero: more than four standard deviations of noise

// Of the joint's range: so narrow that the second harmonic of a whole turn keeps most of its height, and
// wider where few points would lead the line about.
constexpr double kNarrowest = 1.0 / 18, kWidest = 1.0 / 5, kPointsWithin = 3;
constexpr int kCurveSamples = 80;
constexpr std::size_t kFewestPoints = 5;
constexpr int kPasses = 4;  // after the first, each with the weights that the one before gave the points
// Part of the weight that pulls a slope to zero where the points within the bandwidth hardly tell it.
constexpr double kSlopePull = 0.02;

using Pairs = std::vector<std::pair<double, double>>;

/// In which direction each joint moves the reflector, unit length in the tracker's frame; none where it
/// hardly does.
std::vector<std::optional<Eigen::Vector3d>> motions(const ReportDocument& document, const Point& point) {
  const std::vector<Joint>& joints = document.nominal->joints;
  LinkFrames X_B;
  link_frames(*document.nominal, joints_from(point.joints, *document.nominal), X_B);
  const Eigen::Vector3d p_B = document.X_WB->inverse() * *point.position;
  std::vector<std::optional<Eigen::Vector3d>> result(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Eigen::Isometry3d& frame = X_B[i + 1];
    const Eigen::Vector3d axis = joints[i].sign * frame.linear().col(2);
    const bool turns = joints[i].type == JointType::Revolute;
    const Eigen::Vector3d motion = turns ? axis.cross(p_B - frame.translation()).eval() : axis;
    if (turns && motion.norm() < kLeastLeverMm) continue;
    result[i] = document.X_WB->linear() * (turns ? motion.normalized() : motion);
  }
  return result;
}

/// A stage that each chart shows.
struct JointStage {
  std::string name;
  std::string_view color;
  Eigen::Vector3d record::Point::*error;
};

std::vector<JointStage> joint_stages(const ReportDocument& document) {
  std::vector<JointStage> result{{"Geometric", kGeometricColor, &record::Point::geometric}};
  if (has_layers(document.judged())) result.push_back({"All layers", kLayersColor, &record::Point::after});
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
  return document.nominal && document.X_WB && !points.empty() &&
         std::ranges::all_of(points, [&](const Point& p) {
           return p.position && p.joints.size() == document.nominal->joints.size();
         });
}

std::vector<ScatterChart> charts_of(const ReportDocument& document, const std::vector<Point>& points,
                                    const std::vector<JointStage>& stages) {
  const std::vector<Joint>& joints = document.nominal->joints;
  std::vector<ScatterChart> charts;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    ScatterChart& chart = charts.emplace_back();
    chart.title = fmt::format("Joint {}, mm", i + 1);
    chart.x_label = unit_name(joints[i]);
    for (const JointStage& stage : stages) chart.series.push_back({stage.name, stage.color});
  }
  for (const Point& point : points) {
    const auto directions = motions(document, point);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      for (std::size_t k = 0; directions[i] && k < stages.size(); ++k) {
        const double along = (point.*stages[k].error).dot(*directions[i]);
        charts[i].series[k].points.push_back(
            {point.joints[i], along,
             fmt::format("Pose {}, reflector {}: {} mm", point.pose, point.smr, error_text(along))});
      }
    }
  }
  return charts;
}

/// The height at x0 of the line that fits the points next to it.
double value_at(double x0, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y, const Eigen::ArrayXd& trust,
                double bandwidth) {
  const Eigen::ArrayXd dx = (x - x0) / bandwidth, weights = trust * (-dx.square() / 2).exp();
  const double w = weights.sum() + 1e-12;
  const double x_mean = (weights * dx).sum() / w, y_mean = (weights * y).sum() / w;
  const double slope = ((weights * dx * y).sum() - w * x_mean * y_mean) /
                       ((weights * dx.square()).sum() - w * x_mean * x_mean + kSlopePull * w);
  return y_mean - slope * x_mean;
}

double interpolated(const Pairs& curve, double x) {
  const double step = curve[1].first - curve[0].first;
  const auto k = static_cast<std::size_t>(
      std::clamp((x - curve[0].first) / step, 0.0, static_cast<double>(curve.size()) - 2));
  return std::lerp(curve[k].second, curve[k + 1].second, (x - curve[k].first) / step);
}

/// Tukey's bisquare of the distance from the curve, zero from six of the median distance on.
Eigen::ArrayXd trust_in(const Pairs& points, const Pairs& curve) {
  std::vector<double> distances;
  for (const auto& [x, y] : points) distances.push_back(std::abs(y - interpolated(curve, x)));
  const double reach = std::max(6 * median(distances), 1e-12);
  const Eigen::Map<const Eigen::ArrayXd> d{distances.data(), std::ssize(distances)};
  return (1 - (d / reach).square()).cwiseMax(0).square();
}

Pairs curve_through(const Series& series) {
  Pairs points;
  for (const ChartPoint& p : series.points) points.emplace_back(p.x, p.y);
  const auto [lo, hi] = std::ranges::minmax(points, {}, &Pairs::value_type::first);
  const double part = std::clamp(kPointsWithin / static_cast<double>(points.size()), kNarrowest, kWidest);
  const double bandwidth = std::max((hi.first - lo.first) * part, 1e-9);
  return local_regression(points, bandwidth, kCurveSamples);
}

}  // namespace

Pairs local_regression(const Pairs& points, double bandwidth, int samples) {
  if (points.size() < kFewestPoints) return {};
  Eigen::ArrayXd x(std::ssize(points)), y(std::ssize(points)),
      trust = Eigen::ArrayXd::Ones(std::ssize(points));
  for (Eigen::Index i = 0; i < x.size(); ++i) std::tie(x[i], y[i]) = points[static_cast<std::size_t>(i)];
  if (!(x.maxCoeff() > x.minCoeff())) return {};
  Pairs curve;
  for (int pass = 0; pass < kPasses; ++pass) {
    curve.clear();
    for (int k = 0; k < samples; ++k) {
      const double at = x.minCoeff() + k * (x.maxCoeff() - x.minCoeff()) / (samples - 1);
      curve.emplace_back(at, value_at(at, x, y, trust, bandwidth));
    }
    trust = trust_in(points, curve);
  }
  return curve;
}

std::string joint_section(const ReportDocument& document) {
  const std::vector<Point> points = document.judged_points();
  if (!usable(document, points)) return "";
  const std::vector<JointStage> stages = joint_stages(document);
  std::vector<ScatterChart> shown = charts_of(document, points, stages);
  std::erase_if(
      shown, [](const ScatterChart& chart) { return chart.series.front().points.size() < kFewestPlotted; });
  if (shown.empty()) return "";
  std::string keys, svgs;
  for (const JointStage& stage : stages) keys += fmt::format("{}{} ", color_key(stage.color), stage.name);
  const double extent = extent_of(shown);
  for (ScatterChart& chart : shown) {
    chart.y_extent = extent;
    for (const Series& series : chart.series) chart.curves.push_back(curve_through(series));
    svgs += scatter_chart_svg(chart);
  }
  const std::string lead = fmt::format(
      "The part of each error that lies along the motion of the joint, over its position: {} points. A wave in "
      "the smooth line is an error that turns with the joint, such as that of a gear; a flat one says that "
      "nothing of the kind is left. The few points beyond the scale lie on its edge. A joint that hardly "
      "moves the reflector is left out.",
      document.judging_name());
  return section(
      "Residuals, joint by joint",
      note(lead) + fmt::format("<p class=\"key-line\">{}</p>\n", keys) + charts(svgs, "charts three"),
      "whole");
}

}  // namespace truepose::report
