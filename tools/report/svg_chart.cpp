#include "tools/report/svg_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>

#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"

namespace truepose::report {
namespace {

constexpr double kPointWidth = 480, kPointHeight = 280;
constexpr double kHistogramWidth = 320, kHistogramHeight = 220;
constexpr double kRightMargin = 14, kBottomMargin = 44;
constexpr double kCharWidth = 7;  // of the 12 unit font, on the wide side

/// One axis: what it covers, and where on the paper a value lies.
struct Axis {
  double lo, hi;
  double from, to;            // on the paper
  std::vector<double> ticks;  // at least two
  bool logarithmic = false;

  double at(double value) const {
    const double v = std::clamp(value, lo, hi);
    const double fraction = logarithmic ? std::log10(v / lo) / std::log10(hi / lo) : (v - lo) / (hi - lo);
    return from + fraction * (to - from);
  }
};

/// Labels with the decimals that the step between the ticks needs, and no more.
std::vector<std::string> tick_labels(const Axis& axis) {
  std::vector<std::string> result;
  const double step = axis.ticks[1] - axis.ticks[0];
  for (const double tick : axis.ticks) {
    const double last_digit = axis.logarithmic ? tick : step;
    const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(last_digit) + 1e-9)));
    std::string label = decimals > 4 && tick != 0 ? fmt::format("{:.0e}", tick)
                                                  : fmt::format("{:.{}f}", tick, decimals > 4 ? 0 : decimals);
    if (label.starts_with('-')) label.replace(0, 1, "\u2212");
    result.push_back(std::move(label));
  }
  return result;
}

class Drawing {
 public:
  Drawing(std::string_view title, double width, double height)
      : right{width - kRightMargin}, bottom{height - kBottomMargin} {
    put(R"(<svg xmlns="http://www.w3.org/2000/svg" class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">)",
        width, height, xml::escaped(title));
    put(R"(<text class="chart-title" x="0" y="14">{}</text>)", xml::escaped(title));
  }

  const double right, bottom;  ///< edges of the plot

  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  void marker(const Series& series, double x, double y, double r) {
    switch (series.marker) {
      case Marker::HollowCircle:
        put(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="#fff" stroke="{}" stroke-width="1.6">)", x, y, r,
            series.color);
        break;
      case Marker::Circle:
        put(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}">)", x, y, r, series.color);
        break;
      case Marker::Diamond: {
        const double d = 1.35 * r;
        put(R"(<path d="M{:.1f} {:.1f}l{d:.1f} {d:.1f}l-{d:.1f} {d:.1f}l-{d:.1f} -{d:.1f}z" fill="{}">)", x,
            y - d, series.color, fmt::arg("d", d));
        break;
      }
    }
  }
  void end_marker(const Series& series) {
    put("</{}>", series.marker == Marker::Diamond ? "path" : "circle");
  }

  void y_axis(const Axis& axis, const std::vector<std::string>& labels, double left) {
    for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
      const double y = axis.at(axis.ticks[i]);
      const bool zero = !axis.logarithmic && axis.ticks[i] == 0;
      put(R"(<path class="{}" d="M{:.1f} {:.1f}H{}"/>)", zero ? "zero" : "grid", left, y, right);
      put(R"(<text class="tick" text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)", left - 6, y + 4,
          labels[i]);
    }
  }

  void x_axis(const Axis& axis, std::string_view label) {
    const std::vector<std::string> labels = tick_labels(axis);
    put(R"(<path class="axis" d="M{:.1f} {}H{}"/>)", axis.from, bottom, axis.to);
    for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
      put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", axis.at(axis.ticks[i]),
          bottom + 17, labels[i]);
    }
    put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", (axis.from + axis.to) / 2,
        bottom + 36, xml::escaped(label));
  }

  std::string finish() && { return std::move(svg_) + "</svg>\n"; }

 private:
  std::string svg_;
};

/// Width that the y axis needs for its labels.
double label_width(const std::vector<std::string>& labels) {
  std::size_t longest = 0;
  for (const std::string& label : labels) longest = std::max(longest, label.size());
  return 10 + kCharWidth * static_cast<double>(longest);
}

Axis value_axis(const PointChart& chart, double bottom, double top) {
  double lo = chart.log_y ? 1e300 : 0, hi = chart.log_y ? 1e-300 : 0;
  for (const Series& series : chart.series) {
    for (const ChartPoint& p : series.points) {
      if (chart.log_y && !(p.y > 0)) continue;
      lo = std::min(lo, p.y);
      hi = std::max(hi, p.y);
    }
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

/// Draws the legend in as many lines as it needs, and returns the y below it.
double legend(Drawing& drawing, const std::vector<Series>& series) {
  double x = 0, y = 34;
  for (const Series& s : series) {
    const double width = 22 + kCharWidth * static_cast<double>(s.name.size());
    if (x > 0 && x + width > drawing.right) {
      x = 0;
      y += 18;
    }
    drawing.marker(s, x + 6, y - 4, 4);
    drawing.end_marker(s);
    drawing.put(R"(<text class="legend" x="{:.1f}" y="{}">{}</text>)", x + 16, y, xml::escaped(s.name));
    x += width + 10;
  }
  return y + 14;
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
  const double top = legend(drawing, chart.series);
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
    for (const ChartPoint& p : series.points) {
      drawing.marker(series, x.at(p.x), y.at(p.y), radius);
      if (!p.label.empty()) drawing.put("<title>{}</title>", xml::escaped(p.label));
      drawing.end_marker(series);
    }
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
