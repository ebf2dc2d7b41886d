#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <cstddef>
#include <map>

#include "core/calibrate/option_names.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

std::string facts_section(std::string_view title, std::string_view tables) {
  return section(title, fmt::format("<div class=\"columns\">\n{}</div>\n", tables), "whole");
}

/// "0.005 mm + 0.001 mm/m"
std::string with_distance_text(double mm, double mm_per_m) {
  if (mm_per_m == 0) return sigma_text(mm) + " mm";
  return (mm == 0 ? "" : sigma_text(mm) + " mm + ") + sigma_text(mm_per_m) + " mm/m";
}

std::string noise_text(const MeasurementNoise& noise) {
  return fmt::format("{} along the beam, {} across it, repeatability {} mm",
                     with_distance_text(noise.tracker.range_mm, noise.tracker.range_mm_per_m),
                     with_distance_text(noise.tracker.transverse_mm, noise.tracker.transverse_mm_per_m),
                     sigma_text(noise.repeatability_mm));
}

std::string extent_text(const std::optional<record::Extent>& extent, std::string_view unit) {
  if (!extent) return "";
  const std::string lo = fmt::format("{:.1f}", extent->min), hi = fmt::format("{:.1f}", extent->max);
  return lo == hi ? fmt::format("{} {}", lo, unit) : fmt::format("{} to {} {}", lo, hi, unit);
}

Facts arm_facts(const ReportDocument& document) {
  Facts facts{{"Robot", xml::escaped(document.robot)}};
  if (!document.nominal) return facts;
  const RobotModel& arm = *document.nominal;
  if (arm.name != document.robot) facts.emplace_back("Data sheet", xml::escaped(arm.name));
  facts.emplace_back("Joints", fmt::format("{}", arm.joints.size()));
  double kg = arm.payload ? arm.payload->mass_kg : 0;
  for (const LinkMass& mass : arm.masses) kg += mass.mass_kg;
  if (kg > 0) facts.emplace_back("Mass moved, payload included", fmt::format("{:.4g} kg", kg));
  return facts;
}

/// "1: 60 points, 2: 58 points"
std::string reflector_text(const ReportDocument& document) {
  std::map<std::string, int> points;
  for (const Point& p : document.all_points) ++points[p.smr];
  std::string text;
  for (const auto& [name, count] : points)
    text += fmt::format("{}{}: {} points", text.empty() ? "" : ", ", name, count);
  return text;
}

Facts measurement_facts(const ReportDocument& document) {
  Facts facts{{"Tracker", xml::escaped(document.tracker)}};
  if (document.X_WB) {
    facts.emplace_back("Tracker from the robot's base",
                       fmt::format("{:.2f} m", document.X_WB->translation().norm() / 1000));
  }
  facts.emplace_back("Reflectors", xml::escaped(reflector_text(document)));
  if (!document.conditions) return facts;
  const record::Conditions& conditions = *document.conditions;
  facts.emplace_back("Time",
                     xml::escaped(time_text(conditions.started) + " to " + time_text(conditions.ended)));
  facts.emplace_back(
      "Poses", fmt::format("{} measured, {} skipped", conditions.poses_measured, conditions.poses_skipped));
  facts.emplace_back("Air temperature", extent_text(conditions.temperature_c, "°C"));
  facts.emplace_back("Air pressure", extent_text(conditions.pressure_mbar, "mbar"));
  facts.emplace_back("Humidity", extent_text(conditions.humidity_percent, "%"));
  return facts;
}

Facts skipped_facts(const std::vector<record::SkippedPose>& skipped) {
  Facts facts;
  for (const auto& [pose, attempts, reason] : skipped) {
    facts.emplace_back(
        fmt::format("Pose {}, after {} {}", pose, attempts, attempts == 1 ? "attempt" : "attempts"),
        xml::escaped(reason));
  }
  return facts;
}

Facts interruption_facts(const std::vector<record::Interruption>& interruptions) {
  Facts facts;
  for (const auto& [interrupted, resumed, found] : interruptions)
    facts.emplace_back(xml::escaped(time_text(interrupted) + " to " + time_text(resumed)),
                       xml::escaped(found));
  return facts;
}

Facts station_facts(const std::vector<record::Station>& stations) {
  Facts facts;
  for (const record::Station& station : stations)
    facts.emplace_back(xml::escaped(station.name), xml::escaped(station_text(station)));
  return facts;
}

void add_texts(Facts& facts, const record::ByName<std::string>& texts) {
  for (const auto& [what, text] : texts) facts.emplace_back(xml::escaped(what), xml::escaped(text));
}

Facts identification_facts(const ReportDocument& document) {
  const auto counts = [](const StageErrors& set) {
    return fmt::format("{} poses, {} points", set.poses, set.points);
  };
  Facts facts;
  add_texts(facts, document.files);
  for (const std::string& each : document.read_as) facts.emplace_back("Read as", xml::escaped(each));
  facts.emplace_back("Model", xml::escaped(document.model));
  facts.emplace_back("Method", std::string{name_of(record::kMethods, document.method)});
  add_texts(facts, document.options);
  facts.emplace_back("Identified with", counts(document.identify));
  facts.emplace_back("Validated with", document.validate ? counts(*document.validate) : "nothing");
  if (document.noise) facts.emplace_back("Noise of a point, as given", noise_text(*document.noise));
  return facts;
}

std::string elapsed_text(double seconds) {
  return seconds < 1 ? fmt::format("{:.3g} ms", 1000 * seconds) : fmt::format("{:.3g} s", seconds);
}

Facts result_facts(const ReportDocument& document) {
  return {
      {"Converged", document.converged ? "yes" : "no"},
      {"Iterations", fmt::format("{} coarse, {} fine", document.iterations.coarse, document.iterations.fine)},
      {"Time to identify", elapsed_text(document.elapsed_s)},
      {"Geometric parameters determined",
       fmt::format("{} of {}", document.rank, document.geometric_parameters())},
      {"Condition number", fmt::format("{:.4g} (columns scaled to unit norm)", document.condition)},
      {"Noise of one coordinate, from the residuals",
       document.sigma0_mm ? sigma_text(*document.sigma0_mm) + " mm" : ""}};
}

}  // namespace

std::string time_text(const std::string& rfc3339) {
  const bool known = rfc3339.size() >= 20 && rfc3339[10] == 'T' && rfc3339.back() == 'Z';
  return known ? rfc3339.substr(0, 10) + " " + rfc3339.substr(11, 5) + " UTC" : rfc3339;
}

std::string conditions_section(const ReportDocument& document) {
  const std::string left =
      facts_table("Arm", arm_facts(document)) + facts_table("Measurement", measurement_facts(document)) +
      facts_table("Tracker stations", station_facts(document.stations)) +
      facts_table("Poses that were skipped",
                  skipped_facts(document.skipped.value_or(std::vector<record::SkippedPose>{}))) +
      facts_table("Interruptions", interruption_facts(document.interruptions));
  const std::string right = facts_table("Identification", identification_facts(document)) +
                            facts_table("Result", result_facts(document));
  return facts_section("Conditions", fmt::format("<div>\n{}</div>\n<div>\n{}</div>\n", left, right));
}

std::string drift_section(const ReportDocument& document) {
  const std::vector<double>& drift = document.reference_drift_mm;
  if (drift.size() < 2) return "";
  Series series{"Reference pose", kGeometricColor};
  for (std::size_t i = 0; i < drift.size(); ++i) {
    series.points.push_back({static_cast<double>(i + 1), drift[i],
                             fmt::format("Measurement {}: {} mm", i + 1, error_text(drift[i]))});
  }
  const std::string lead = fmt::format(
      "One pose was measured {} times in between. Its distance from where it was first shows what the "
      "tracker's stand, the robot's base and the arm's temperature did meanwhile: {} mm at most, {} mm at the "
      "end.",
      drift.size(), error_text(std::ranges::max(drift)), error_text(drift.back()));
  const std::string svg = point_chart_svg({.title = "Distance from the first measurement",
                                           .x_label = "measurement of the reference pose",
                                           .y_unit = "mm",
                                           .series = {std::move(series)}});
  return section("Drift while it was measured", note(lead) + charts(svg), "whole");
}

std::string stream_section(const ReportDocument& document) {
  if (!document.stream) return "";
  const record::Stream& stream = *document.stream;
  const auto of_cycles = [cycles = stream.cycles](std::int64_t n) {
    const std::string count = fmt::format("{}", n);
    if (cycles <= 0) return count;
    return fmt::format("{} ({:.4g} %)", count, 100 * static_cast<double>(n) / static_cast<double>(cycles));
  };
  const auto turnaround = [&stream](double record::Stream::Turnaround::*us) {
    return fmt::format("{:.0f} µs", stream.turnaround_us.*us);
  };
  return facts_section(
      "Stream of corrections",
      facts_table(
          "",
          {{"Cycles", fmt::format("{}", stream.cycles)},
           {"Answered", of_cycles(stream.answered)},
           {"Late", of_cycles(stream.late)},
           {"Not answered: at the start of sessions, until the correction in effect is known",
            of_cycles(stream.unconfirmed)},
           {"Not answered: out of order by their IPOC", of_cycles(stream.wrong_ipoc)},
           {"Largest step of the correction in one cycle", fmt::format("{:.4g} deg", stream.max_step_deg)},
           {"Time from a datagram to its reply, median", turnaround(&record::Stream::Turnaround::p50)},
           {"99 % within", turnaround(&record::Stream::Turnaround::p99)},
           {"99.9 % within", turnaround(&record::Stream::Turnaround::p999)},
           {"Slowest", turnaround(&record::Stream::Turnaround::max)}}));
}

}  // namespace truepose::report
