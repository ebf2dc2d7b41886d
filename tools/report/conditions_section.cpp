#include "tools/report/conditions_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

/// @param value  escaped; no row where it is empty
std::string known_fact(std::string_view name, std::string_view value) {
  return value.empty() ? "" : fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", name, value);
}

/// A table under a heading, nothing where there are no rows.
std::string facts_table(std::string_view title, std::string_view rows) {
  if (rows.empty()) return "";
  return fmt::format("<div class=\"facts\">\n{}<table>\n<tbody>\n{}</tbody>\n</table>\n</div>\n",
                     title.empty() ? "" : fmt::format("<h3>{}</h3>\n", title), rows);
}

std::string facts_section(std::string_view title, std::string_view tables) {
  return fmt::format(
      "<section class=\"whole\">\n<h2>{}</h2>\n<div class=\"columns\">\n{}</div>\n</section>\n", title,
      tables);
}

/// "0.005 mm + 0.001 mm/m"
std::string with_distance_text(double mm, double mm_per_m) {
  if (mm_per_m == 0) return sigma_text(mm) + " mm";
  return (mm == 0 ? "" : sigma_text(mm) + " mm + ") + sigma_text(mm_per_m) + " mm/m";
}

std::string noise_text(const MeasurementNoise& noise) {
  const TrackerNoiseModel& tracker = noise.tracker;
  return fmt::format("{} along the beam, {} across it, repeatability {} mm",
                     with_distance_text(tracker.range_mm, tracker.range_mm_per_m),
                     with_distance_text(tracker.transverse_mm, tracker.transverse_mm_per_m),
                     sigma_text(noise.repeatability_mm));
}

std::string range_text(const std::optional<Range>& range, std::string_view unit) {
  if (!range) return "";
  const std::string lo = fmt::format("{:.1f}", range->min), hi = fmt::format("{:.1f}", range->max);
  return lo == hi ? fmt::format("{} {}", lo, unit) : fmt::format("{} to {} {}", lo, hi, unit);
}

std::string arm_rows(const ReportDocument& document) {
  std::string rows = known_fact("Robot", xml::escaped(document.robot));
  const Setup& setup = document.setup;
  if (!setup.arm) return rows;
  if (setup.arm->name != document.robot) rows += known_fact("Data sheet", xml::escaped(setup.arm->name));
  rows += known_fact("Joints", fmt::format("{}", setup.arm->joints.size()));
  double kg = 0;
  for (const LinkMass& mass : setup.arm->masses) kg += mass.mass_kg;
  if (kg > 0) rows += known_fact("Mass moved, payload included", fmt::format("{:.4g} kg", kg));
  return rows;
}

/// "1: 60 points, 2: 58 points"
std::string reflector_text(const ReportDocument& document) {
  std::map<std::string, int> points;
  for (const Point& p : document.points) ++points[p.smr];
  std::string text;
  for (const auto& [name, count] : points) {
    text += fmt::format("{}{}: {} points", text.empty() ? "" : ", ", name, count);
  }
  return text;
}

std::string measurement_rows(const ReportDocument& document) {
  const Setup& setup = document.setup;
  std::string rows = known_fact("Tracker", xml::escaped(document.tracker));
  if (setup.X_WB) {
    rows += known_fact("Tracker from the robot's base",
                       fmt::format("{:.2f} m", setup.X_WB->translation().norm() / 1000));
  }
  rows += known_fact("Reflectors", xml::escaped(reflector_text(document)));
  if (!setup.conditions) return rows;
  const Conditions& c = *setup.conditions;
  rows += known_fact("Time", xml::escaped(time_text(c.started) + " to " + time_text(c.ended)));
  rows += known_fact("Poses", fmt::format("{} measured, {} skipped", c.poses_measured, c.poses_skipped));
  rows += known_fact("Air temperature", range_text(c.temperature_c, "°C"));
  rows += known_fact("Air pressure", range_text(c.pressure_mbar, "mbar"));
  return rows + known_fact("Humidity", range_text(c.humidity_percent, "%"));
}

std::string skipped_rows(const Setup& setup) {
  std::string rows;
  for (const Skipped& pose : setup.skipped) {
    rows += known_fact(fmt::format("Pose {}, after {} {}", pose.pose, pose.attempts,
                                   pose.attempts == 1 ? "attempt" : "attempts"),
                       xml::escaped(pose.reason));
  }
  return rows;
}

std::string elapsed_text(double seconds) {
  return seconds < 1 ? fmt::format("{:.3g} ms", 1000 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string identification_rows(const ReportDocument& document) {
  const auto counts = [](const Stages& set) {
    return fmt::format("{} poses, {} points", set.poses, set.points);
  };
  std::string rows;
  for (const auto& [name, value] : document.setup.files)
    rows += known_fact(xml::escaped(name), xml::escaped(value));
  rows +=
      known_fact("Model", xml::escaped(document.model)) + known_fact("Method", xml::escaped(document.method));
  for (const auto& [name, value] : document.setup.options)
    rows += known_fact(xml::escaped(name), xml::escaped(value));
  rows += known_fact("Identified with", counts(document.identify));
  rows +=
      known_fact("Validated with", document.validate ? counts(*document.validate) : std::string("nothing"));
  if (document.findings.noise)
    rows += known_fact("Noise of a point, as given", noise_text(*document.findings.noise));
  return rows;
}

std::string result_rows(const ReportDocument& document) {
  std::string rows = known_fact("Converged", document.converged ? "yes" : "no");
  rows += known_fact("Iterations",
                     fmt::format("{} coarse, {} fine", document.coarse_iterations, document.fine_iterations));
  rows += known_fact("Time to identify", elapsed_text(document.elapsed_s));
  rows += known_fact("Geometric parameters determined",
                     fmt::format("{} of {}", document.rank, document.geometric_parameters()));
  rows +=
      known_fact("Condition number", fmt::format("{:.4g} (columns scaled to unit norm)", document.condition));
  if (document.findings.sigma0_mm) {
    rows += known_fact("Noise of one coordinate, from the residuals",
                       sigma_text(*document.findings.sigma0_mm) + " mm");
  }
  return rows;
}

}  // namespace

std::string conditions_section(const ReportDocument& document) {
  const std::string left = facts_table("Arm", arm_rows(document)) +
                           facts_table("Measurement", measurement_rows(document)) +
                           facts_table("Poses that were skipped", skipped_rows(document.setup));
  const std::string right = facts_table("Identification", identification_rows(document)) +
                            facts_table("Result", result_rows(document));
  return facts_section("Conditions", fmt::format("<div>\n{}</div>\n<div>\n{}</div>\n", left, right));
}

std::string drift_section(const ReportDocument& document) {
  const std::vector<double>& drift = document.setup.reference_drift_mm;
  if (drift.size() < 2) return "";
  Series series{"Reference pose", std::string(kGeometricColor), Marker::Circle, {}};
  for (std::size_t i = 0; i < drift.size(); ++i) {
    series.points.push_back({static_cast<double>(i + 1), drift[i],
                             fmt::format("Measurement {}: {} mm", i + 1, error_text(drift[i]))});
  }
  return fmt::format(
             "<section class=\"whole\">\n<h2>Drift while it was measured</h2>\n<p class=\"note\">One pose "
             "was "
             "measured {} times in between. Its distance from where it was first shows what the tracker's "
             "stand, the robot's base and the arm's temperature did meanwhile: {} mm at most, {} mm at the "
             "end.</p>\n<div class=\"charts\">\n",
             drift.size(), error_text(std::ranges::max(drift)), error_text(drift.back())) +
         point_chart_svg({.title = "Distance from the first measurement",
                          .x_label = "measurement of the reference pose",
                          .y_unit = "mm",
                          .series = {std::move(series)}}) +
         "</div>\n</section>\n";
}

std::string stream_section(const ReportDocument& document) {
  if (!document.stream) return "";
  const Stream& s = *document.stream;
  const auto of_cycles = [&s](long long n) {
    return s.cycles > 0
               ? fmt::format("{} ({:.4g} %)", n, 100 * static_cast<double>(n) / static_cast<double>(s.cycles))
               : fmt::format("{}", n);
  };
  const std::string rows =
      known_fact("Cycles", fmt::format("{}", s.cycles)) + known_fact("Answered", of_cycles(s.answered)) +
      known_fact("Late", of_cycles(s.late)) +
      known_fact("Not answered: at the start of sessions, until known what is in force",
                 of_cycles(s.unproven)) +
      known_fact("Not answered: out of order by their IPOC", of_cycles(s.wrong_ipoc)) +
      known_fact("Largest step of the correction in one cycle", fmt::format("{:.4g} deg", s.max_step_deg)) +
      known_fact("Time from a datagram to its reply, median", fmt::format("{:.0f} µs", s.p50_us)) +
      known_fact("99 % within", fmt::format("{:.0f} µs", s.p99_us)) +
      known_fact("99.9 % within", fmt::format("{:.0f} µs", s.p999_us)) +
      known_fact("Slowest", fmt::format("{:.0f} µs", s.max_us));
  return facts_section("Stream of corrections", facts_table("", rows));
}

}  // namespace truepose::report
