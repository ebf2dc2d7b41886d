#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string_view>
#include <utility>

#include "daemon/report/charts.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/report.hpp"

namespace truepose::report {
namespace {

constexpr std::size_t kMostDrawn = 1000;

using ValueOf = std::function<double(const CompensationRow&)>;

/// Of very many rows every k-th.
Series over_targets(const CompensationReport& report, Series series, const ValueOf& value) {
  const std::size_t step = (report.rows.size() + kMostDrawn - 1) / kMostDrawn;
  for (std::size_t i = 0; i < report.rows.size(); i += step) {
    const double y = value(report.rows[i]);
    series.points.push_back(
        {static_cast<double>(i + 1), y, fmt::format("{}, target {}: {:.3g}", series.name, i + 1, y)});
  }
  return series;
}

std::string chart_over_targets(std::string title, std::string unit, bool log_y, std::vector<Series> series) {
  return boxed(point_chart_svg({.title = std::move(title),
                                .x_label = "target",
                                .y_unit = std::move(unit),
                                .log_y = log_y,
                                .series = std::move(series)}));
}

std::string corrections(const CompensationReport& report) {
  std::vector<Series> series;
  for (std::size_t axis = 0; axis < report.rows.front().corrections.size(); ++axis) {
    series.push_back(over_targets(report, series_of_palette(fmt::format("joint {}", axis + 1), axis),
                                  [axis](const CompensationRow& row) { return row.corrections[axis]; }));
  }
  return chart_over_targets("Added to the joints", "deg (mm)", false, std::move(series));
}

std::string residuals(const CompensationReport& report) {
  const auto chart = [&report](const char* title, const char* unit, bool log_y, const char* name,
                               std::string_view color, const ValueOf& value) {
    return chart_over_targets(title, unit, log_y, {over_targets(report, {name, color}, value)});
  };
  std::string html = chart("Position that is left", "mm, logarithmic", true, "position", kCompensatedColor,
                           &CompensationRow::residual_mm);
  if (!report.position_only)
    html += chart("Orientation that is left", "deg", false, "orientation", kGeometricColor,
                  &CompensationRow::residual_deg);
  if (report.rows.front().sigma_mm)
    html += chart("Standard deviation of where the arm will stand", "mm", false, "sigma", kLayersColor,
                  [](const CompensationRow& row) { return row.sigma_mm.value_or(0); });
  return html;
}

double largest(const CompensationReport& report, const ValueOf& value) {
  double result = 0;
  for (const CompensationRow& row : report.rows) result = std::max(result, std::abs(value(row)));
  return result;
}

double largest_step(const CompensationReport& report) {
  double step = 0;
  for (std::size_t i = 1; i < report.rows.size(); ++i) {
    for (std::size_t k = 0; k < report.rows[i].corrections.size(); ++k)
      step = std::max(step, std::abs(report.rows[i].corrections[k] - report.rows[i - 1].corrections[k]));
  }
  return step;
}

std::string facts(const CompensationReport& report) {
  const auto largest_correction = [](const CompensationRow& row) {
    double most = 0;
    for (const double correction : row.corrections) most = std::max(most, std::abs(correction));
    return most;
  };
  Table table{"facts", {{}, {}}};
  table.row("Targets", {std::to_string(report.rows.size())});
  table.row("Largest correction of a joint",
            {fmt::format("{:.4f} deg (mm)", largest(report, largest_correction))});
  table.row("Largest change of a correction between neighbours",
            {fmt::format("{:.4f} deg (mm)", largest_step(report))});
  table.row("Position that is left at most",
            {fmt::format("{:.1e} mm", largest(report, &CompensationRow::residual_mm))});
  if (!report.position_only) {
    table.row("Orientation that is left at most",
              {fmt::format("{:.4f} deg", largest(report, &CompensationRow::residual_deg))});
    table.row("Damped next to the wrist singularity",
              {std::to_string(std::ranges::count_if(report.rows, &CompensationRow::damped))});
  }
  return std::move(table).scrolled();
}

}  // namespace

std::string render_compensation_html(const CompensationReport& report) {
  return html_page("Compensated targets",
                   page_header("Compensated targets", report.robot, report.targets) +
                       section("", facts(report)) +
                       section("Target by target", charts(corrections(report) + residuals(report)), "whole"));
}

}  // namespace truepose::report
