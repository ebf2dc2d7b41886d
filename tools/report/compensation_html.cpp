#include "tools/report/compensation_html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "tools/report/html_page.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

constexpr std::size_t kMostDrawn = 1000;

using ValueOf = std::function<double(const CompensationRow&)>;

/// Of very many rows every k-th.
Series series_of(const CompensationReport& report, std::string name, std::string_view color, Marker marker,
                 const ValueOf& value) {
  Series series{std::move(name), std::string(color), marker, {}};
  const std::size_t step = (report.rows.size() + kMostDrawn - 1) / kMostDrawn;
  for (std::size_t i = 0; i < report.rows.size(); i += step) {
    const double y = value(report.rows[i]);
    series.points.push_back(
        {static_cast<double>(i + 1), y, fmt::format("{}, target {}: {:.3g}", series.name, i + 1, y)});
  }
  return series;
}

std::string figure(std::string title, std::string unit, bool log_y, std::vector<Series> series) {
  return "<div>" +
         point_chart_svg({.title = std::move(title),
                          .x_label = "target",
                          .y_unit = std::move(unit),
                          .log_y = log_y,
                          .series = std::move(series)}) +
         "</div>\n";
}

std::string corrections(const CompensationReport& report) {
  // Okabe and Ito's palette, and grey.
  static constexpr std::array kColors{"#0072b2", "#d55e00", "#00805e", "#cc79a7",
                                      "#e69f00", "#56b4e9", "#7b4fa3", "#586673"};
  static constexpr std::array kMarkers{Marker::Circle, Marker::HollowCircle, Marker::Diamond};
  std::vector<Series> series;
  for (std::size_t axis = 0; axis < report.rows.front().corrections.size(); ++axis) {
    series.push_back(series_of(report, fmt::format("joint {}", axis + 1), kColors[axis % kColors.size()],
                               kMarkers[axis % kMarkers.size()],
                               [axis](const CompensationRow& row) { return row.corrections[axis]; }));
  }
  return figure("Added to the joints", "deg (mm)", false, std::move(series));
}

std::string residuals(const CompensationReport& report) {
  std::string html = figure("Position that is left", "mm, logarithmic", true,
                            {series_of(report, "position", kCompensatedColor, Marker::Circle,
                                       [](const CompensationRow& row) { return row.residual_mm; })});
  if (!report.position_only) {
    html += figure("Orientation that is left", "deg", false,
                   {series_of(report, "orientation", kGeometricColor, Marker::Circle,
                              [](const CompensationRow& row) { return row.residual_deg; })});
  }
  if (report.rows.front().sigma_mm) {
    html += figure("Standard deviation of where the arm will stand", "mm", false,
                   {series_of(report, "sigma", kLayersColor, Marker::Circle,
                              [](const CompensationRow& row) { return row.sigma_mm.value_or(0); })});
  }
  return html;
}

double largest(const CompensationReport& report, const ValueOf& value) {
  double result = 0;
  for (const CompensationRow& row : report.rows) result = std::max(result, std::abs(value(row)));
  return result;
}

std::string fact(std::string_view what, const std::string& value) {
  return fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", what, value);
}

std::string facts(const CompensationReport& report) {
  const auto largest_correction = [](const CompensationRow& row) {
    double most = 0;
    for (const double correction : row.corrections) most = std::max(most, std::abs(correction));
    return most;
  };
  double step = 0;
  for (std::size_t i = 1; i < report.rows.size(); ++i) {
    for (std::size_t k = 0; k < report.rows[i].corrections.size(); ++k)
      step = std::max(step, std::abs(report.rows[i].corrections[k] - report.rows[i - 1].corrections[k]));
  }
  const auto damped = std::ranges::count_if(report.rows, &CompensationRow::damped);
  std::string html =
      fact("Targets", std::to_string(report.rows.size())) +
      fact("Largest correction of a joint",
           fmt::format("{:.4f} deg (mm)", largest(report, largest_correction))) +
      fact("Largest change of a correction between neighbours", fmt::format("{:.4f} deg (mm)", step)) +
      fact("Position that is left at most",
           fmt::format("{:.1e} mm", largest(report, std::mem_fn(&CompensationRow::residual_mm))));
  if (!report.position_only) {
    html += fact("Orientation that is left at most",
                 fmt::format("{:.4f} deg", largest(report, std::mem_fn(&CompensationRow::residual_deg)))) +
            fact("Damped next to the wrist singularity", std::to_string(damped));
  }
  return html;
}

}  // namespace

std::string render_compensation_html(const CompensationReport& report) {
  return html_page(
      "Compensated targets",
      page_header("Compensated targets", report.robot, report.targets) +
          fmt::format(
              "<section>\n<div class=\"scroll\"><table class=\"facts\"><tbody>\n{}</tbody></table></div>\n"
              "</section>\n<section class=\"whole\">\n<h2>Target by target</h2>\n<div class=\"charts\">\n"
              "{}{}</div>\n</section>\n",
              facts(report), corrections(report), residuals(report)));
}

}  // namespace truepose::report
