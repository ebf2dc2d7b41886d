#include "tools/report/svg_drawing.hpp"

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

}  // namespace

double Axis::at(double value) const {
  const double v = std::clamp(value, lo, hi);
  const double fraction = logarithmic ? std::log10(v / lo) / std::log10(hi / lo) : (v - lo) / (hi - lo);
  return from + fraction * (to - from);
}

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

double label_width(const std::vector<std::string>& labels) {
  std::size_t longest = 0;
  for (const std::string& label : labels) longest = std::max(longest, label.size());
  return 10 + kCharWidth * static_cast<double>(longest);
}

Drawing::Drawing(std::string_view title, double width, double height)
    : right{width - kRightMargin}, bottom{height - kBottomMargin} {
  put(R"(<svg xmlns="http://www.w3.org/2000/svg" class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">)",
      width, height, xml::escaped(title));
  put(R"(<text class="chart-title" x="0" y="14">{}</text>)", xml::escaped(title));
}

void Drawing::marker(const Series& series, double x, double y, double r) {
  switch (is_large(series) ? Marker::Circle : series.marker) {
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

void Drawing::end_marker(const Series& series) {
  put("</{}>", series.marker == Marker::Diamond && !is_large(series) ? "path" : "circle");
}

void Drawing::points(const Series& series, const Axis& x, const Axis& y, double radius) {
  if (is_large(series)) {
    put(R"(<path class="dots" fill="none" stroke="{}" stroke-width="{:.1f}" stroke-linecap="round" d=")",
        series.color, 2 * radius);
    for (const ChartPoint& p : series.points) put("M{:.1f} {:.1f}h0", x.at(p.x), y.at(p.y));
    put(R"("/>)");
    return;
  }
  for (const ChartPoint& p : series.points) {
    marker(series, x.at(p.x), y.at(p.y), radius);
    if (!p.label.empty()) put("<title>{}</title>", xml::escaped(p.label));
    end_marker(series);
  }
}

void Drawing::y_axis(const Axis& axis, const std::vector<std::string>& labels, double left) {
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    const double y = axis.at(axis.ticks[i]);
    const bool zero = !axis.logarithmic && axis.ticks[i] == 0;
    put(R"(<path class="{}" d="M{:.1f} {:.1f}H{}"/>)", zero ? "zero" : "grid", left, y, right);
    put(R"(<text class="tick" text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)", left - 6, y + 4,
        labels[i]);
  }
}

void Drawing::x_axis(const Axis& axis, std::string_view label) {
  const std::vector<std::string> labels = tick_labels(axis);
  put(R"(<path class="axis" d="M{:.1f} {}H{}"/>)", axis.from, bottom, axis.to);
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", axis.at(axis.ticks[i]),
        bottom + 17, labels[i]);
  }
  put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", (axis.from + axis.to) / 2,
      bottom + 36, xml::escaped(label));
}

double Drawing::legend(const std::vector<Series>& series) {
  double x = 0, y = 34;
  for (const Series& s : series) {
    const double width = 22 + kCharWidth * static_cast<double>(s.name.size());
    if (x > 0 && x + width > right) {
      x = 0;
      y += 18;
    }
    marker(s, x + 6, y - 4, 4);
    end_marker(s);
    put(R"(<text class="legend" x="{:.1f}" y="{}">{}</text>)", x + 16, y, xml::escaped(s.name));
    x += width + 10;
  }
  return y + 14;
}

}  // namespace truepose::report
