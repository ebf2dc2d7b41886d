#include "tools/report/box_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

constexpr double kWidth = 760, kLeft = 280, kRight = kWidth - 30;
constexpr double kTop = 30, kRowHeight = 24, kBoxHeight = 12, kBottomMargin = 44;
constexpr double kSmallest = 1e-12;

/// Where a value lies on the paper.
class LogAxis {
 public:
  explicit LogAxis(const std::vector<BoxRow>& rows) {
    double lo = 1e300, hi = kSmallest;
    for (const BoxRow& row : rows) {
      lo = std::min(lo, std::max(row.min, kSmallest));
      hi = std::max(hi, row.max);
    }
    ticks = log_ticks(std::min(lo, hi), hi, 8);
  }
  double at(double value) const {
    const double lo = ticks.front(), hi = ticks.back();
    return kLeft + std::log(std::clamp(value, lo, hi) / lo) / std::log(hi / lo) * (kRight - kLeft);
  }

  std::vector<double> ticks;
};

std::string box(const BoxRow& row, const LogAxis& axis, double y) {
  const double from = axis.at(row.lower), to = axis.at(row.upper), half = kBoxHeight / 2;
  std::string svg =
      fmt::format(R"(<g><title>{}: {} to {} mm, half of them {} to {}, median {}</title>)"
                  R"(<text class="legend" text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)",
                  xml::escaped(row.name), error_text(row.min), error_text(row.max), error_text(row.lower),
                  error_text(row.upper), error_text(row.median), kLeft - 10, y + 4, xml::escaped(row.name));
  svg += fmt::format(R"(<path stroke="{}" d="M{:.1f} {:.1f}H{:.1f}"/>)", row.color, axis.at(row.min), y,
                     axis.at(row.max));
  svg += fmt::format(
      R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{}" fill="#fff" stroke="{}" stroke-width="1.6"/>)",
      from, y - half, std::max(to - from, 1.0), kBoxHeight, row.color);
  return svg + fmt::format(R"(<path stroke="{}" stroke-width="2.4" d="M{:.1f} {:.1f}v{}"/></g>)", row.color,
                           axis.at(row.median), y - half, kBoxHeight);
}

}  // namespace

std::string box_chart_svg(const std::string& title, const std::string& x_label,
                          const std::vector<BoxRow>& rows) {
  const LogAxis axis{rows};
  const double bottom = kTop + kRowHeight * static_cast<double>(rows.size());
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}">)"
      R"(<text class="chart-title" x="0" y="14">{}</text>)",
      kWidth, bottom + kBottomMargin, xml::escaped(title), xml::escaped(title));
  for (const double tick : axis.ticks) {
    svg += fmt::format(R"(<path class="grid" d="M{:.1f} {}V{}"/>)", axis.at(tick), kTop, bottom);
    svg += fmt::format(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{:.3g}</text>)",
                       axis.at(tick), bottom + 17, tick);
  }
  svg += fmt::format(R"(<text class="tick" text-anchor="middle" x="{:.1f}" y="{}">{}</text>)",
                     (kLeft + kRight) / 2, bottom + 36, xml::escaped(x_label));
  double y = kTop + kRowHeight / 2;
  for (const BoxRow& row : rows) {
    svg += box(row, axis, y);
    y += kRowHeight;
  }
  return svg + "</svg>\n";
}

}  // namespace truepose::report
