#include "daemon/report/charts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/math/statistics.hpp"
#include "daemon/report/number_text.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr double kSmallestBoxed = 1e-12;

/// Light to dark in one hue, so that a grey print keeps the order.
constexpr std::array<std::array<double, 3>, 4> kHeatColors{
    {{0xf1, 0xf6, 0xfb}, {0x9e, 0xc5, 0xe3}, {0x2f, 0x7f, 0xbd}, {0x08, 0x2a, 0x54}}};
constexpr int kScaleSteps = 24;

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
  if (chart.log_y && lo <= hi) return covering(log_ticks(lo, hi, 7), bottom, top, true);
  return covering(nice_ticks(std::min(lo, 0.0), std::max(hi, 0.0), 5), bottom, top);
}

/// As far as the points reach.
Axis scatter_axis(const ScatterChart& chart, double left, double right) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (const Series& series : chart.series) {
    for (const ChartPoint& p : series.points) {
      lo = std::min(lo, p.x);
      hi = std::max(hi, p.x);
    }
  }
  if (!(hi > lo)) hi = lo + 1;
  return within(lo, hi, left, right, 5, 0.03 * (hi - lo));
}

void draw_box(Plot& plot, const Box& box, const Axis& x, double y) {
  constexpr double kHeight = 12;
  const double from = x.at(box.lower), to = x.at(box.upper), top = y - kHeight / 2;
  plot.put(R"(<g><title>{}: {} to {} mm, half of them {} to {}, median {}</title>)"
           R"(<text class="legend" text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)",
           xml::escaped(box.name), error_text(box.min), error_text(box.max), error_text(box.lower),
           error_text(box.upper), error_text(box.median), plot.left - 10, y + 4, xml::escaped(box.name));
  plot.put(R"(<path stroke="{}" d="M{:.1f} {:.1f}H{:.1f}"/>)", box.color, x.at(box.min), y, x.at(box.max));
  plot.put(
      R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{}" fill="#fff" stroke="{}" stroke-width="1.6"/>)",
      from, top, std::max(to - from, 1.0), kHeight, box.color);
  plot.put(R"(<path stroke="{}" stroke-width="2.4" d="M{:.1f} {:.1f}v{}"/></g>)", box.color, x.at(box.median),
           top, kHeight);
}

/// Each sample is the middle of its cell, so the outer cells reach half a step beyond the swept range.
void draw_cells(Plot& plot, const HeatMap& map, double width, double height) {
  for (std::size_t row = 0; row < map.values.size(); ++row) {
    for (std::size_t column = 0; column < map.values[row].size(); ++column) {
      const double value = map.values[row][column];
      // A little larger than the cell, so that no seam of the page shows between two.
      plot.rectangle(plot.left + width * static_cast<double>(column),
                     plot.bottom - height * static_cast<double>(row + 1), width + 0.3, height + 0.3,
                     map.scale.color(value), sigma_text(value) + " mm");
    }
  }
}

}  // namespace

Series series_of_palette(std::string name, std::size_t k) {
  // Okabe and Ito's palette, and grey.
  static constexpr std::array kColors{"#0072b2", "#d55e00", "#00805e", "#cc79a7",
                                      "#e69f00", "#56b4e9", "#7b4fa3", "#586673"};
  static constexpr std::array kMarkers{Marker::Circle, Marker::HollowCircle, Marker::Diamond};
  return {std::move(name), kColors[k % kColors.size()], kMarkers[k % kMarkers.size()]};
}

std::string point_chart_svg(const PointChart& chart) {
  Plot plot{chart.title + ", " + chart.y_unit, 480, 280};
  plot.legend(chart.series);
  const Axis y = value_axis(chart, plot.bottom, plot.top);
  plot.left = y.label_width();

  std::size_t count = 0;
  double last = 5;  // never so short that the ticks are not whole numbers
  for (const Series& series : chart.series) {
    count = std::max(count, series.points.size());
    for (const ChartPoint& p : series.points) last = std::max(last, p.x);
  }
  const Axis x = within(0, last + 1, plot.left, plot.right, 6);
  plot.y_axis(y);
  plot.x_axis(x, chart.x_label);

  const double radius = count <= 60 ? 3.2 : count <= 200 ? 2.2 : 1.6;
  for (const Series& series : chart.series) {
    if (series.points.size() > 1 && count <= 200) {
      std::vector<Eigen::Vector2d> line;
      for (const ChartPoint& p : series.points) line.emplace_back(x.at(p.x), y.at(p.y));
      plot.line(line, fmt::format(R"(fill="none" stroke="{}" stroke-opacity="0.35")", series.color));
    }
    plot.points(series, x, y, radius);
  }
  return std::move(plot).finish();
}

std::string scatter_chart_svg(const ScatterChart& chart) {
  Plot plot{chart.title, 360, 250};
  const Axis y = covering(nice_ticks(-chart.y_extent, chart.y_extent, 5), plot.bottom, 26);
  plot.left = y.label_width();
  const Axis x = scatter_axis(chart, plot.left, plot.right);
  plot.y_axis(y);
  plot.x_axis(x, chart.x_label);
  for (const Series& series : chart.series) {
    plot.put(R"(<g opacity="0.45">)");
    plot.points(series, x, y, series.points.size() <= 100 ? 2.4 : 1.5);
    plot.put("</g>");
  }
  for (std::size_t k = 0; k < chart.curves.size(); ++k) {
    if (chart.curves[k].empty()) continue;
    std::vector<Eigen::Vector2d> line;
    for (const auto& [at_x, at_y] : chart.curves[k]) line.emplace_back(x.at(at_x), y.at(at_y));
    plot.line(line, fmt::format(R"(class="curve" fill="none" stroke="{}" stroke-width="2.2")",
                                chart.series[k].color));
  }
  return std::move(plot).finish();
}

std::string histogram_svg(const Histogram& chart) {
  const double largest = std::ranges::max(chart.values);
  const int bins =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(chart.values.size())))) + 2, 5, 20);
  const std::vector<double> edges = nice_ticks(0, largest, bins);
  std::vector<int> counts(edges.size() - 1);
  for (const double value : chart.values) {
    const auto above = std::ranges::upper_bound(edges, value);
    const auto bin = std::clamp<std::ptrdiff_t>(above - edges.begin() - 1, 0, std::ssize(counts) - 1);
    ++counts[static_cast<std::size_t>(bin)];
  }

  Plot plot{chart.title, 320, 220};
  const Axis y = covering(nice_ticks(0, std::max(std::ranges::max(counts), 5), 5), plot.bottom, plot.top);
  plot.left = y.label_width();
  const Axis x = within(0, edges.back(), plot.left, plot.right, 6);
  plot.y_axis(y);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const double from = x.at(edges[i]) + 1, to = x.at(edges[i + 1]) - 1,
                 height = plot.bottom - y.at(counts[i]);
    plot.rectangle(from, plot.bottom - height, to - from, height, chart.color,
                   fmt::format("{} to {} mm: {}", error_text(edges[i]), error_text(edges[i + 1]), counts[i]));
  }
  plot.x_axis(x, chart.x_label);
  return std::move(plot).finish();
}

std::string box_chart_svg(const std::string& title, const std::string& x_label,
                          const std::vector<Box>& boxes) {
  constexpr double kRowHeight = 24;
  Plot plot{title, 760, 74 + kRowHeight * static_cast<double>(boxes.size())};
  plot.left = 280;
  plot.right = 730;
  double lo = 1e300, hi = kSmallestBoxed;
  for (const Box& box : boxes) {
    lo = std::min(lo, std::max(box.min, kSmallestBoxed));
    hi = std::max(hi, box.max);
  }
  const Axis x = covering(log_ticks(std::min(lo, hi), hi, 8), plot.left, plot.right, true);
  plot.x_axis(x, x_label, AxisLines::Grid);
  double y = plot.top + kRowHeight / 2;
  for (const Box& box : boxes) {
    draw_box(plot, box, x, y);
    y += kRowHeight;
  }
  return std::move(plot).finish();
}

std::string ColorScale::color(double value) const {
  const double v = std::clamp(value, lo, hi);
  const double part = !(hi > lo)      ? 0
                      : logarithmic() ? std::log(v / lo) / std::log(hi / lo)
                                      : (v - lo) / (hi - lo);
  const double place = part * static_cast<double>(kHeatColors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kHeatColors.size() - 2);
  const double rest = place - static_cast<double>(below);
  const auto channel = [&](std::size_t k) {
    return static_cast<int>(std::lround(std::lerp(kHeatColors[below][k], kHeatColors[below + 1][k], rest)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2));
}

void draw_scale(Plot& plot, const ColorScale& scale, std::string_view title, double top) {
  const double step = (plot.right - plot.left) / kScaleSteps, below = top + 25;
  for (int k = 0; k < kScaleSteps; ++k) {
    const double part = (k + 0.5) / kScaleSteps;
    const double value = scale.logarithmic() ? scale.lo * std::pow(scale.hi / scale.lo, part)
                                             : scale.lo + part * (scale.hi - scale.lo);
    plot.put(R"(<rect x="{:.1f}" y="{}" width="{:.1f}" height="10" fill="{}"/>)", plot.left + k * step, top,
             step + 0.3, scale.color(value));
  }
  plot.put(R"(<text class="tick" x="{}" y="{}">{} mm</text>)", plot.left, below, sigma_text(scale.lo));
  plot.put(R"(<text class="tick" text-anchor="end" x="{}" y="{}">{} mm</text>)", plot.right, below,
           sigma_text(scale.hi));
  plot.put(R"(<text class="tick" text-anchor="middle" x="{}" y="{}">{}{}</text>)",
           (plot.left + plot.right) / 2, below, xml::escaped(title),
           scale.logarithmic() ? ", logarithmic" : "");
}

double exaggeration_of(std::vector<double> errors_mm, double length_mm) {
  // The median, so that outliers leave the picture rather than shrink it.
  const double usual_mm = median(std::move(errors_mm));
  if (!(usual_mm > 0)) return 1;
  const double wanted = length_mm / usual_mm, decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * decade <= wanted) return factor * decade;
  }
  return decade;
}

std::string heat_map_svg(const HeatMap& map) {
  Plot plot{map.title, 480, 400};
  plot.left = 58;
  plot.top = 26;
  plot.bottom = 312;
  const double width = (plot.right - plot.left) / static_cast<double>(map.values[0].size());
  const double height = (plot.bottom - plot.top) / static_cast<double>(map.values.size());
  const Axis x = within(map.x_from, map.x_to, plot.left + width / 2, plot.right - width / 2, 6);
  const Axis y = within(map.y_from, map.y_to, plot.bottom - height / 2, plot.top + height / 2, 6);
  draw_cells(plot, map, width, height);
  for (const auto& [mark_x, mark_y] : map.marks) {
    if (!x.holds(mark_x) || !y.holds(mark_y)) continue;
    plot.put(R"(<circle class="mark" cx="{:.1f}" cy="{:.1f}" r="{}"/>)", x.at(mark_x), y.at(mark_y),
             map.marks.size() > 200 ? 1.4 : 2.4);
  }
  plot.x_axis(x, map.x_label, AxisLines::None);
  plot.y_axis(y, map.y_label, AxisLines::None);
  draw_scale(plot, map.scale, "standard deviation", plot.bottom + 54);
  return std::move(plot).finish();
}

}  // namespace truepose::report
