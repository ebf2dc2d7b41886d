#include "daemon/report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr double kRightMargin = 14, kBottomMargin = 44;
constexpr double kCharWidth = 7;  // of the 12 unit font, on the wide side

/// Whether markers with labels would make the page heavy and hide each other anyway.
bool is_large(const Series& series) { return series.points.size() >= 250; }

/// The smallest round number (1, 2 or 5 times a power of ten) that is not below the value.
double round_up(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= value * (1 - 1e-9)) return factor * decade;
  }
  return 10 * decade;
}

}  // namespace

std::vector<double> nice_ticks(double lo, double hi, int at_most) {
  if (!(hi > lo)) hi = lo + (lo == 0 ? 1 : std::abs(lo));
  const double step = round_up((hi - lo) / at_most);
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

double Axis::at(double value) const {
  const double v = std::clamp(value, lo, hi);
  const double fraction = logarithmic ? std::log10(v / lo) / std::log10(hi / lo) : (v - lo) / (hi - lo);
  return from + fraction * (to - from);
}

std::vector<std::string> Axis::labels() const {
  std::vector<std::string> result;
  const double step = ticks[1] - ticks[0];
  for (const double tick : ticks) {
    const double last_digit = logarithmic ? tick : step;
    const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(last_digit) + 1e-9)));
    std::string label = decimals > 4 && tick != 0 ? fmt::format("{:.0e}", tick)
                                                  : fmt::format("{:.{}f}", tick, decimals > 4 ? 0 : decimals);
    if (label.starts_with('-')) label.replace(0, 1, "\u2212");
    result.push_back(std::move(label));
  }
  return result;
}

double Axis::label_width() const {
  std::size_t longest = 0;
  for (const std::string& label : labels()) longest = std::max(longest, label.size());
  return 10 + kCharWidth * static_cast<double>(longest);
}

Axis covering(std::vector<double> ticks, double from, double to, bool logarithmic) {
  return {ticks.front(), ticks.back(), from, to, std::move(ticks), logarithmic};
}

Axis within(double lo, double hi, double from, double to, int ticks, double margin) {
  if (hi < lo) return within(hi, lo, to, from, ticks, margin);
  Axis axis{lo - margin, hi + margin, from, to, nice_ticks(lo, hi, ticks)};
  const double rounding = 1e-9 * (hi - lo);
  std::erase_if(axis.ticks,
                [&](double tick) { return tick < axis.lo - rounding || tick > axis.hi + rounding; });
  if (axis.ticks.size() < 2) axis.ticks = {lo, hi};
  return axis;
}

Plot::Plot(std::string_view title, double width, double height, std::string_view classes,
           std::string_view attributes)
    : right{width - kRightMargin}, bottom{height - kBottomMargin} {
  put(R"(<svg xmlns="http://www.w3.org/2000/svg" class="{}" viewBox="0 0 {} {}" role="img" aria-label="{}"{}>)",
      classes, width, height, xml::escaped(title), attributes);
  put(R"(<text class="chart-title" x="0" y="14">{}</text>)", xml::escaped(title));
}

void Plot::rectangle(double x, double y, double width, double height, std::string_view color,
                     std::string_view label) {
  put(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"><title>{}</title></rect>)", x,
      y, width, height, color, xml::escaped(label));
}

void Plot::line(std::span<const Eigen::Vector2d> points, std::string_view attributes) {
  put(R"(<path {} d=")", attributes);
  for (std::size_t i = 0; i < points.size(); ++i)
    put("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", points[i].x(), points[i].y());
  put(R"("/>)");
}

void Plot::marker(const Series& series, double x, double y, double r, std::string_view label) {
  const Marker kind = is_large(series) ? Marker::Circle : series.marker;
  if (kind == Marker::Diamond) {
    put(R"(<path d="M{:.1f} {:.1f}l{d:.1f} {d:.1f}l-{d:.1f} {d:.1f}l-{d:.1f} -{d:.1f}z" fill="{}">)", x,
        y - 1.35 * r, series.color, fmt::arg("d", 1.35 * r));
  } else if (kind == Marker::HollowCircle) {
    put(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="#fff" stroke="{}" stroke-width="1.6">)", x, y, r,
        series.color);
  } else {
    put(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}">)", x, y, r, series.color);
  }
  if (!label.empty()) put("<title>{}</title>", xml::escaped(label));
  put("</{}>", kind == Marker::Diamond ? "path" : "circle");
}

void Plot::points(const Series& series, const Axis& x, const Axis& y, double radius) {
  if (is_large(series)) {
    put(R"(<path class="dots" fill="none" stroke="{}" stroke-width="{:.1f}" stroke-linecap="round" d=")",
        series.color, 2 * radius);
    for (const ChartPoint& p : series.points) put("M{:.1f} {:.1f}h0", x.at(p.x), y.at(p.y));
    put(R"("/>)");
    return;
  }
  for (const ChartPoint& p : series.points) marker(series, x.at(p.x), y.at(p.y), radius, p.label);
}

void Plot::y_axis(const Axis& axis, std::string_view label, AxisLines lines) {
  const std::vector<std::string> labels = axis.labels();
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    const double y = axis.at(axis.ticks[i]);
    const bool zero = !axis.logarithmic && axis.ticks[i] == 0;
    if (lines == AxisLines::Grid)
      put(R"(<path class="{}" d="M{:.1f} {:.1f}H{}"/>)", zero ? "zero" : "grid", left, y, right);
    put(R"(<text class="tick" text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)", left - 6, y + 4,
        labels[i]);
  }
  if (label.empty()) return;
  put(R"svg(<text class="tick" text-anchor="middle" transform="translate(12 {}) rotate(-90)">{}</text>)svg",
      (top + bottom) / 2, xml::escaped(label));
}

void Plot::x_axis(const Axis& axis, std::string_view label, AxisLines lines) {
  const std::vector<std::string> labels = axis.labels();
  if (lines == AxisLines::Axis) put(R"(<path class="axis" d="M{:.1f} {}H{}"/>)", axis.from, bottom, axis.to);
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    const double x = axis.at(axis.ticks[i]);
    if (lines == AxisLines::Grid) put(R"(<path class="grid" d="M{:.1f} {}V{}"/>)", x, top, bottom);
    put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", x, bottom + 17, labels[i]);
  }
  put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", (axis.from + axis.to) / 2,
      bottom + 36, xml::escaped(label));
}

void Plot::legend(const std::vector<Series>& series) {
  double x = 0, y = 34;
  for (const Series& s : series) {
    const double width = 22 + kCharWidth * static_cast<double>(s.name.size());
    if (x > 0 && x + width > right) {
      x = 0;
      y += 18;
    }
    marker(s, x + 6, y - 4, 4);
    put(R"(<text class="legend" x="{:.1f}" y="{}">{}</text>)", x + 16, y, xml::escaped(s.name));
    x += width + 10;
  }
  top = y + 14;
}

}  // namespace truepose::report
