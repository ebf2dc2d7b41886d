#include "tools/report/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

constexpr double kWidth = 480, kHeight = 400;
constexpr double kLeft = 58, kRight = kWidth - 14, kTop = 26, kBottom = 312;
constexpr double kScaleTop = 366, kScaleHeight = 10;
constexpr int kScaleSteps = 24;

/// Light to dark in one hue, so that a grey print keeps the order.
constexpr std::array<std::array<double, 3>, 4> kColors{
    {{0xf1, 0xf6, 0xfb}, {0x9e, 0xc5, 0xe3}, {0x2f, 0x7f, 0xbd}, {0x08, 0x2a, 0x54}}};

class Canvas {
 public:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }
  std::string finish() && { return std::move(svg_) + "</svg>\n"; }

 private:
  std::string svg_;
};

double between(double value, double from, double to) { return (value - from) / (to - from); }

/// Each sample is the middle of its cell, so the outer cells reach half a step beyond the swept range.
void draw_cells(Canvas& canvas, const HeatMap& map) {
  const auto rows = static_cast<double>(map.values.size()),
             columns = static_cast<double>(map.values[0].size());
  const double width = (kRight - kLeft) / columns, height = (kBottom - kTop) / rows;
  for (std::size_t row = 0; row < map.values.size(); ++row) {
    for (std::size_t column = 0; column < map.values[row].size(); ++column) {
      const double value = map.values[row][column];
      // A little larger than the cell, so that no seam of the page shows between two.
      canvas.put(
          R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="{}"><title>{} mm</title></rect>)",
          kLeft + width * static_cast<double>(column), kBottom - height * static_cast<double>(row + 1),
          width + 0.3, height + 0.3, map.scale.color(value), sigma_text(value));
    }
  }
}

struct Span {
  double from, to;    ///< outer samples
  double start, end;  ///< where they lie on the paper
  double at(double value) const { return start + between(value, from, to) * (end - start); }
  bool holds(double value) const { return value >= std::min(from, to) && value <= std::max(from, to); }
  std::vector<double> ticks() const {
    std::vector<double> inside;
    for (const double tick : nice_ticks(std::min(from, to), std::max(from, to), 6)) {
      if (holds(tick)) inside.push_back(tick);
    }
    return inside;
  }
};

std::string tick_text(double tick) { return fmt::format("{}{:g}", tick < 0 ? "\u2212" : "", std::abs(tick)); }

void draw_axes(Canvas& canvas, const HeatMap& map, const Span& x, const Span& y) {
  for (const double tick : x.ticks()) {
    canvas.put(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)", x.at(tick),
               kBottom + 17, tick_text(tick));
  }
  for (const double tick : y.ticks()) {
    canvas.put(R"(<text class="tick" text-anchor="end" x="{}" y="{:.1f}">{}</text>)", kLeft - 6,
               y.at(tick) + 4, tick_text(tick));
  }
  canvas.put(R"(<text class="tick" text-anchor="middle" x="{}" y="{}">{}</text>)", (kLeft + kRight) / 2,
             kBottom + 36, xml::escaped(map.x_label));
  canvas.put(
      R"svg(<text class="tick" text-anchor="middle" transform="translate(12 {}) rotate(-90)">{}</text>)svg",
      (kTop + kBottom) / 2, xml::escaped(map.y_label));
}

void draw_scale(Canvas& canvas, const ColorScale& scale) {
  const double step = (kRight - kLeft) / kScaleSteps;
  for (int k = 0; k < kScaleSteps; ++k) {
    const double part = (k + 0.5) / kScaleSteps;
    const double value = scale.logarithmic() ? scale.lo * std::pow(scale.hi / scale.lo, part)
                                             : scale.lo + part * (scale.hi - scale.lo);
    canvas.put(R"(<rect x="{:.1f}" y="{}" width="{:.1f}" height="{}" fill="{}"/>)", kLeft + k * step,
               kScaleTop, step + 0.3, kScaleHeight, scale.color(value));
  }
  canvas.put(R"(<text class="tick" x="{}" y="{}">{} mm</text>)", kLeft, kScaleTop + 25, sigma_text(scale.lo));
  canvas.put(R"(<text class="tick" text-anchor="end" x="{}" y="{}">{} mm</text>)", kRight, kScaleTop + 25,
             sigma_text(scale.hi));
  canvas.put(R"(<text class="tick" text-anchor="middle" x="{}" y="{}">standard deviation{}</text>)",
             (kLeft + kRight) / 2, kScaleTop + 25, scale.logarithmic() ? ", logarithmic" : "");
}

}  // namespace

std::string ColorScale::color(double value) const {
  const double v = std::clamp(value, lo, hi);
  const double part = !(hi > lo)      ? 0
                      : logarithmic() ? std::log(v / lo) / std::log(hi / lo)
                                      : between(v, lo, hi);
  const double place = part * static_cast<double>(kColors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kColors.size() - 2);
  const double rest = place - static_cast<double>(below);
  const auto channel = [&](std::size_t k) {
    return static_cast<int>(
        std::lround(kColors[below][k] + rest * (kColors[below + 1][k] - kColors[below][k])));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2));
}

std::string heat_map_svg(const HeatMap& map) {
  const double half_x = (kRight - kLeft) / static_cast<double>(map.values[0].size()) / 2;
  const double half_y = (kBottom - kTop) / static_cast<double>(map.values.size()) / 2;
  const Span x{map.x_from, map.x_to, kLeft + half_x, kRight - half_x};
  const Span y{map.y_from, map.y_to, kBottom - half_y, kTop + half_y};
  Canvas canvas;
  canvas.put(
      R"(<svg xmlns="http://www.w3.org/2000/svg" class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">)",
      kWidth, kHeight, xml::escaped(map.title));
  canvas.put(R"(<text class="chart-title" x="0" y="14">{}</text>)", xml::escaped(map.title));
  draw_cells(canvas, map);
  for (const auto& [mark_x, mark_y] : map.marks) {
    if (!x.holds(mark_x) || !y.holds(mark_y)) continue;
    canvas.put(R"(<circle class="mark" cx="{:.1f}" cy="{:.1f}" r="{}"/>)", x.at(mark_x), y.at(mark_y),
               map.marks.size() > 200 ? 1.4 : 2.4);
  }
  draw_axes(canvas, map, x, y);
  draw_scale(canvas, map.scale);
  return std::move(canvas).finish();
}

}  // namespace truepose::report
