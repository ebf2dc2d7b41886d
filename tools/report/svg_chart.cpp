#include "tools/report/svg_chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/svg_drawing.hpp"

namespace truepose::report {
namespace {

constexpr double kPointWidth = 480, kPointHeight = 280;
constexpr double kHistogramWidth = 320, kHistogramHeight = 220;

Axis value_axis(const PointChart& chart, double bottom, double top) {
  double lo = chart.log_y ? 1e300 : 0, hi = chart.log_y ? 1e-300 : 0;
  for (const Series& series : chart.series) {
    for (const ChartPoint& p : series.points) {
      if (chart.log_y && !(p.y > 0)) continue;
      lo = std::min(lo, p.y);
      hi = std::max(hi, p.y);
    }
  }
  if (chart.y_limit > 0) {
    lo = std::max(lo, -chart.y_limit);
    hi = std::min(hi, chart.y_limit);
  }
  const bool logarithmic = chart.log_y && lo <= hi;
  std::vector<double> ticks =
      logarithmic ? log_ticks(lo, hi, 7) : nice_ticks(std::min(lo, 0.0), std::max(hi, 0.0), 5);
  return {ticks.front(), ticks.back(), bottom, top, ticks, logarithmic};
}

/// An axis that ends at `hi`, with the round numbers that lie within.
Axis axis_to(double hi, double from, double to) {
  std::vector<double> ticks = nice_ticks(0, hi, 6);
  while (ticks.size() > 2 && ticks.back() > hi * (1 + 1e-9)) ticks.pop_back();
  return {0, std::max(hi, ticks.back()), from, to, ticks};
}

}  // namespace

std::vector<double> nice_ticks(double lo, double hi, int at_most) {
  if (!(hi > lo)) hi = lo + (lo == 0 ? 1 : std::abs(lo));
  const double raw = (hi - lo) / at_most;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * decade;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= raw * (1 - 1e-9)) {
      step = factor * decade;
      break;
    }
  }
  std::vector<double> ticks;
  // Multiples counted in whole numbers, so that zero is zero.
  const double first = std::floor(lo / step + 1e-9), last = std::ceil(hi / step - 1e-9);
  for (double k = first; k <= last; ++k) ticks.push_back(k == 0 ? 0 : k * step);
  return ticks;
}

std::vector<double> log_ticks(double lo, double hi, int at_most) {
  const int first = static_cast<int>(std::floor(std::log10(lo)));
  const int last = static_cast<int>(std::ceil(std::log10(hi)));
  std::vector<double> ticks;
  for (int decade = first; decade <= last; ++decade) {
    for (const double factor : {1.0, 2.0, 5.0}) ticks.push_back(factor * std::pow(10.0, decade));
  }
  // Keep the closest cover of lo..hi.
  while (ticks.size() > 2 && ticks[1] <= lo) ticks.erase(ticks.begin());
  while (ticks.size() > 2 && ticks[ticks.size() - 2] >= hi) ticks.pop_back();
  if (static_cast<int>(ticks.size()) <= at_most) return ticks;

  const int step = std::max(1, (last - first + at_most - 1) / at_most);
  ticks.clear();
  for (int decade = first; decade < last + step; decade += step) ticks.push_back(std::pow(10.0, decade));
  return ticks;
}

std::string point_chart_svg(const PointChart& chart) {
  Drawing drawing{chart.title + ", " + chart.y_unit, kPointWidth, kPointHeight};
  const double top = drawing.legend(chart.series);
  const Axis y = value_axis(chart, drawing.bottom, top);
  const std::vector<std::string> y_labels = tick_labels(y);
  const double left = label_width(y_labels);

  std::size_t count = 0;
  double last = 1;
  for (const Series& series : chart.series) {
    count = std::max(count, series.points.size());
    for (const ChartPoint& p : series.points) last = std::max(last, p.x);
  }
  // Room beside the last marker; never so short that the ticks are not whole numbers.
  const Axis x = axis_to(std::max(last, 5.0) + 1, left, drawing.right);
  drawing.y_axis(y, y_labels, left);
  drawing.x_axis(x, chart.x_label);

  const double radius = count <= 60 ? 3.2 : count <= 200 ? 2.2 : 1.6;
  for (const Series& series : chart.series) {
    if (series.points.size() > 1 && count <= 200) {
      drawing.put(R"(<path fill="none" stroke="{}" stroke-opacity="0.35" d=")", series.color);
      for (std::size_t i = 0; i < series.points.size(); ++i) {
        const ChartPoint& p = series.points[i];
        drawing.put("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", x.at(p.x), y.at(p.y));
      }
      drawing.put(R"("/>)");
    }
    drawing.points(series, x, y, radius);
  }
  return std::move(drawing).finish();
}

std::string histogram_svg(const HistogramChart& chart) {
  const double largest = *std::max_element(chart.values.begin(), chart.values.end());
  const int bins =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(chart.values.size())))) + 2, 5, 20);
  const std::vector<double> edges = nice_ticks(0, largest, bins);
  std::vector<int> counts(edges.size() - 1);
  for (const double value : chart.values) {
    const auto above = std::upper_bound(edges.begin(), edges.end(), value);
    const auto bin = std::clamp<std::ptrdiff_t>(above - edges.begin() - 1, 0, std::ssize(counts) - 1);
    ++counts[static_cast<std::size_t>(bin)];
  }
  const int highest = *std::max_element(counts.begin(), counts.end());

  Drawing drawing{chart.title, kHistogramWidth, kHistogramHeight};
  const std::vector<double> y_ticks = nice_ticks(0, std::max(highest, 5), 5);
  const Axis y{0, y_ticks.back(), drawing.bottom, 30, y_ticks};
  const std::vector<std::string> y_labels = tick_labels(y);
  const double left = label_width(y_labels);
  const Axis x = axis_to(edges.back(), left, drawing.right);
  drawing.y_axis(y, y_labels, left);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const double from = x.at(edges[i]) + 1, to = x.at(edges[i + 1]) - 1,
                 height = drawing.bottom - y.at(counts[i]);
    drawing.put(
        R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"><title>{} to {} mm: {}</title></rect>)",
        from, drawing.bottom - height, to - from, height, chart.color, error_text(edges[i]),
        error_text(edges[i + 1]), counts[i]);
  }
  drawing.x_axis(x, chart.x_label);
  return std::move(drawing).finish();
}

}  // namespace truepose::report
