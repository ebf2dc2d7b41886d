#include "tools/report/scatter_chart.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "tools/report/svg_drawing.hpp"

namespace truepose::report {
namespace {

constexpr double kScatterWidth = 360, kScatterHeight = 250;

/// As far as the points reach, with the round numbers that lie within.
Axis scatter_axis(const ScatterChart& chart, double left, double right) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (const Series& series : chart.series) {
    for (const ChartPoint& p : series.points) {
      lo = std::min(lo, p.x);
      hi = std::max(hi, p.x);
    }
  }
  if (!(hi > lo)) hi = lo + 1;
  const double margin = 0.03 * (hi - lo);
  Axis axis{lo - margin, hi + margin, left, right, {}};
  for (const double tick : nice_ticks(lo, hi, 5)) {
    if (tick >= axis.lo && tick <= axis.hi) axis.ticks.push_back(tick);
  }
  if (axis.ticks.size() < 2) axis.ticks = {lo, hi};
  return axis;
}

}  // namespace

std::string scatter_chart_svg(const ScatterChart& chart) {
  Drawing drawing{chart.title, kScatterWidth, kScatterHeight};
  const std::vector<double> y_ticks = nice_ticks(-chart.y_extent, chart.y_extent, 5);
  const Axis y{y_ticks.front(), y_ticks.back(), drawing.bottom, 26, y_ticks};
  const std::vector<std::string> y_labels = tick_labels(y);
  const double left = label_width(y_labels);
  const Axis x = scatter_axis(chart, left, drawing.right);
  drawing.y_axis(y, y_labels, left);
  drawing.x_axis(x, chart.x_label);

  for (const Series& series : chart.series) {
    const double radius = series.points.size() <= 100 ? 2.4 : 1.5;
    drawing.put(R"(<g opacity="0.45">)");
    drawing.points(series, x, y, radius);
    drawing.put("</g>");
  }
  for (std::size_t k = 0; k < chart.curves.size(); ++k) {
    if (chart.curves[k].empty()) continue;
    drawing.put(R"(<path class="curve" fill="none" stroke="{}" stroke-width="2.2" d=")",
                chart.series[k].color);
    bool first = true;
    for (const auto& [at_x, at_y] : chart.curves[k]) {
      drawing.put("{}{:.1f} {:.1f}", first ? "M" : "L", x.at(at_x), y.at(at_y));
      first = false;
    }
    drawing.put(R"("/>)");
  }
  return std::move(drawing).finish();
}

}  // namespace truepose::report
