#include "tools/report/report_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/kinematics/angles.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {
namespace {

std::string statistics_row(std::string_view name, std::string_view color, const ErrorStatistics& s,
                           std::string_view factor) {
  std::string html = fmt::format(
      "<tr><th scope=\"row\"><span class=\"key\" style=\"background: {}\"></span>{}</th><td "
      "class=\"strong\">{}</td>"
      "<td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
      color, name, error_text(s.mean), error_text(s.max), error_text(s.min), error_text(s.rms),
      error_text(s.std));
  for (const AxisStatistics* axis : {&s.x, &s.y, &s.z}) {
    html += fmt::format("<td class=\"first\">{}</td><td>{}</td>", error_text(axis->mean_abs),
                        error_text(axis->max_abs));
  }
  return html + fmt::format("<td class=\"first\">{}</td></tr>\n", factor);
}

std::string stage_rows(std::string_view title, const Stages& stages, const ErrorStatistics* remeasured) {
  std::string html = fmt::format(
      "<tbody>\n<tr><th class=\"rows\" colspan=\"13\" scope=\"rowgroup\">{}: {} poses, {} points</th></tr>\n",
      title, stages.poses, stages.points);
  const auto factor = [&stages](const ErrorStatistics& s) { return factor_text(stages.before.mean, s.mean); };
  html += statistics_row("Before", kBeforeColor, stages.before, "");
  html += statistics_row("Geometric", kGeometricColor, stages.geometric, factor(stages.geometric));
  if (has_layers(stages))
    html += statistics_row("All layers", kLayersColor, stages.after, factor(stages.after));
  if (remeasured != nullptr)
    html += statistics_row("Compensated", kCompensatedColor, *remeasured, factor(*remeasured));
  return html + "</tbody>\n";
}

/// "base", "smr.1" or "link2" of "base.x", "smr.1.x" or "link2.a".
std::string_view group_of(std::string_view name) { return name.substr(0, name.rfind('.')); }

std::string group_title(std::string_view group) {
  if (group == "base") return "Base of the robot in the tracker's frame";
  if (group.starts_with("smr."))
    return fmt::format("Reflector {} in the flange frame", xml::escaped(group.substr(4)));
  if (group.starts_with("link")) return fmt::format("Link {}", xml::escaped(group.substr(4)));
  return xml::escaped(group);
}

/// Every length is called by one letter (x, a, d); the angles are rx, ry, rz and the Greek ones.
bool is_angle(std::string_view leaf) { return leaf.size() > 1; }

std::string leaf_title(std::string_view leaf) {
  if (leaf == "alpha") return "α";
  if (leaf == "theta") return "θ";
  if (leaf == "beta") return "β";
  return xml::escaped(leaf);
}

std::string parameter_row(const Parameter& parameter, bool with_truth) {
  const IdentifiedParameter& p = parameter.identified;
  const std::string_view name = p.name;
  const std::string_view leaf = name.substr(group_of(name).size() + (name.find('.') == name.npos ? 0 : 1));
  const bool angle = is_angle(leaf);
  const auto text = [angle](double value) { return angle ? angle_text(value) : length_text(value); };
  const bool has_nominal = name.starts_with("link");
  const double sigma = angle ? p.sigma * kDegPerRad : p.sigma;
  std::string html = fmt::format(
      "<tr{}><th scope=\"row\">{}</th><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
      "<td class=\"text first\">{}</td>",
      p.identified ? "" : " class=\"convention\"", leaf_title(leaf), angle ? "deg" : "mm",
      has_nominal ? text(p.nominal) : "", text(p.value), has_nominal ? text(p.value - p.nominal) : "",
      p.identified ? sigma_text(sigma) : "", p.identified ? "identified" : "kept, by convention");
  if (with_truth) {
    std::string truth, difference;
    if (parameter.truth) {
      const double d = p.value - *parameter.truth;
      truth = text(*parameter.truth);
      difference = text(angle ? std::remainder(d, 2 * std::numbers::pi) : d);
    }
    html += fmt::format("<td class=\"first\">{}</td><td>{}</td>", truth, difference);
  }
  return html + "</tr>\n";
}

std::string fact(std::string_view name, std::string_view value) {
  return value.empty() ? "" : fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", name, value);
}

std::string facts_section(std::string_view title, std::string_view rows) {
  return fmt::format(
      "<section class=\"whole\">\n<h2>{}</h2>\n<div class=\"scroll\"><table "
      "class=\"facts\">\n<tbody>\n{}</tbody>\n</table></div>\n"
      "</section>\n",
      title, rows);
}

}  // namespace

std::string statistics_section(const ReportDocument& document) {
  std::string html =
      "<section>\n<h2>Position error before and after</h2>\n<p class=\"note\"><b>Before</b>: the data "
      "sheet's arm, with only "
      "the robot's base and the reflector fitted (coarse stage). <b>Geometric</b>: the identified arm (fine "
      "stage), as it "
      "predicts the measured points.";
  if (has_layers(document.judged())) html += " <b>All layers</b>: with the models beyond geometry.";
  if (document.remeasured) {
    html += " <b>Compensated</b>: validation poses driven to with compensated joints and measured again.";
  }
  html +=
      " All in mm.</p>\n<div class=\"scroll\"><table class=\"statistics\">\n<thead>\n"
      "<tr><th rowspan=\"2\"></th><th class=\"group\" colspan=\"5\">3-D</th><th class=\"group\" "
      "colspan=\"2\">x</th>"
      "<th class=\"group\" colspan=\"2\">y</th><th class=\"group\" colspan=\"2\">z</th>"
      "<th class=\"first\" rowspan=\"2\">times better</th></tr>\n"
      "<tr><th>mean</th><th>max</th><th>min</th><th>RMS</th><th>std</th><th class=\"first\">mean "
      "|x|</th><th>max</th>"
      "<th class=\"first\">mean |y|</th><th>max</th><th class=\"first\">mean "
      "|z|</th><th>max</th></tr>\n</thead>\n";
  const ErrorStatistics* remeasured = document.remeasured ? &*document.remeasured : nullptr;
  if (document.validate) html += stage_rows("Validation", *document.validate, remeasured);
  html += stage_rows("Identification", document.identify, document.validate ? nullptr : remeasured);
  return html + "</table></div>\n</section>\n";
}

std::string parameters_section(const ReportDocument& document) {
  if (document.parameters.empty()) return "";
  const bool with_truth = std::any_of(document.parameters.begin(), document.parameters.end(),
                                      [](const Parameter& p) { return p.truth.has_value(); });
  std::string html = fmt::format(
      "<section>\n<h2>Identified parameters</h2>\n<p class=\"note\">The measured positions determine {} of "
      "{} parameters. "
      "The others are kept at the data sheet's value by convention: what they would do, identified ones do "
      "in their place, and "
      "the predictions are the same. σ is one standard deviation.</p>\n",
      document.rank, document.parameters.size());
  if (with_truth) {
    html +=
        "<p class=\"note\">This arm is simulated, so its true values stand beside. A single value may well "
        "differ from the "
        "truth by more than its σ: only combinations of parameters that the positions determine can be "
        "compared. "
        "The fair comparison is of predictions, that is the validation error above.</p>\n";
  }
  html += fmt::format(
      "<div class=\"scroll\"><table class=\"parameters\">\n<thead>\n<tr><th></th><th "
      "class=\"text\"></th><th>nominal</th>"
      "<th>value</th><th>deviation</th><th>σ</th><th class=\"first\"></th>{}</tr>\n</thead>\n",
      with_truth ? "<th class=\"first\">true value</th><th>value − true</th>" : "");
  std::string_view group;
  for (const Parameter& p : document.parameters) {
    if (const std::string_view own = group_of(p.identified.name); own != group) {
      html +=
          fmt::format("{}<tbody>\n<tr><th class=\"rows\" colspan=\"{}\" scope=\"rowgroup\">{}</th></tr>\n",
                      group.empty() ? "" : "</tbody>\n", with_truth ? 9 : 7, group_title(own));
      group = own;
    }
    html += parameter_row(p, with_truth);
  }
  return html + "</tbody>\n</table></div>\n</section>\n";
}

std::string stream_section(const ReportDocument& document) {
  if (!document.stream) return "";
  const Stream& s = *document.stream;
  const auto of_cycles = [&s](long long n) {
    return s.cycles > 0
               ? fmt::format("{} ({:.4g} %)", n, 100 * static_cast<double>(n) / static_cast<double>(s.cycles))
               : fmt::format("{}", n);
  };
  return facts_section(
      "Stream of corrections",
      fact("Cycles", fmt::format("{}", s.cycles)) + fact("Answered", of_cycles(s.answered)) +
          fact("Late", of_cycles(s.late)) + fact("Answered with a wrong IPOC", of_cycles(s.wrong_ipoc)) +
          fact("Largest step of the correction in one cycle", fmt::format("{:.4g} deg", s.max_step_deg)) +
          fact("Time from a datagram to its reply, median", fmt::format("{:.0f} µs", s.p50_us)) +
          fact("99 % within", fmt::format("{:.0f} µs", s.p99_us)) +
          fact("99.9 % within", fmt::format("{:.0f} µs", s.p999_us)) +
          fact("Slowest", fmt::format("{:.0f} µs", s.max_us)));
}

std::string conditions_section(const ReportDocument& document) {
  std::string rows =
      fact("Robot", xml::escaped(document.robot)) + fact("Tracker", xml::escaped(document.tracker)) +
      fact("Campaign", xml::escaped(document.campaign)) + fact("Method", xml::escaped(document.method));
  rows += fact("Converged", document.converged ? "yes" : "no");
  rows += fact("Iterations",
               fmt::format("{} coarse, {} fine", document.coarse_iterations, document.fine_iterations));
  rows +=
      fact("Time to identify", document.elapsed_s < 1 ? fmt::format("{:.3g} ms", 1000 * document.elapsed_s)
                                                      : fmt::format("{:.3g} s", document.elapsed_s));
  rows += fact("Identified with",
               fmt::format("{} poses, {} points", document.identify.poses, document.identify.points));
  rows += fact("Validated with",
               document.validate
                   ? fmt::format("{} poses, {} points", document.validate->poses, document.validate->points)
                   : std::string("nothing"));
  rows += fact("Parameters determined", fmt::format("{} of {}", document.rank, document.parameters.size()));
  rows += fact("Condition number", fmt::format("{:.4g} (columns scaled to unit norm)", document.condition));
  return facts_section("Conditions", rows);
}

}  // namespace truepose::report
