#include "tools/report/report_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/math/angles.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/findings_text.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {
namespace {

/// One row of the table of errors.
struct StatisticsRow {
  std::string_view name, color;
  const ErrorStatistics& errors;
  const StageSpread* spread = nullptr;  ///< over the runs of the validation, where there were several
};

std::string statistics_row(const StatisticsRow& row, std::string_view factor) {
  const ErrorStatistics& s = row.errors;
  const auto with_spread = [&row](double value, double StageSpread::*deviation) {
    if (!row.spread) return error_text(value);
    return fmt::format("{} <span class=\"spread\">± {}</span>", error_text(value),
                       error_text(row.spread->*deviation));
  };
  std::string html = fmt::format(
      "<tr><th scope=\"row\"><span class=\"key\" style=\"background: {}\"></span>{}</th><td "
      "class=\"strong\">{}</td>"
      "<td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
      row.color, row.name, with_spread(s.mean, &StageSpread::mean), with_spread(s.max, &StageSpread::max),
      error_text(s.min), with_spread(s.rms, &StageSpread::rms), error_text(s.std));
  for (const AxisStatistics* axis : {&s.x, &s.y, &s.z}) {
    html += fmt::format("<td class=\"first\">{}</td><td>{}</td>", error_text(axis->mean_abs),
                        error_text(axis->max_abs));
  }
  return html + fmt::format("<td class=\"first\">{}</td></tr>\n", factor);
}

std::string stage_rows(std::string_view title, const Stages& stages, const ErrorStatistics* remeasured,
                       const Spread* spread) {
  std::string html = fmt::format(
      "<tbody>\n<tr><th class=\"rows\" colspan=\"13\" scope=\"rowgroup\">{}: {} poses, {} points</th></tr>\n",
      title, stages.poses, stages.points);
  const auto factor = [&stages](const ErrorStatistics& s) { return factor_text(stages.before.mean, s.mean); };
  const auto of = [spread](StageSpread Spread::*stage) { return spread ? &(spread->*stage) : nullptr; };
  html += statistics_row({"Before", kBeforeColor, stages.before, of(&Spread::before)}, "");
  html += statistics_row({"Geometric", kGeometricColor, stages.geometric, of(&Spread::geometric)},
                         factor(stages.geometric));
  if (has_layers(stages))
    html +=
        statistics_row({"All layers", kLayersColor, stages.after, of(&Spread::after)}, factor(stages.after));
  if (remeasured != nullptr)
    html += statistics_row({"Compensated", kCompensatedColor, *remeasured}, factor(*remeasured));
  return html + "</tbody>\n";
}

/// "base", "smr.1" or "link2" of "base.x", "smr.1.x" or "link2.a".
std::string_view group_of(std::string_view name) { return name.substr(0, name.rfind('.')); }

std::string group_title(std::string_view group) {
  if (group == "base") return "Base of the robot in the tracker's frame";
  if (group.starts_with("smr."))
    return fmt::format("Reflector {} in the flange frame", xml::escaped(group.substr(4)));
  if (group.starts_with("joint")) return fmt::format("Deviation of joint {}", xml::escaped(group.substr(5)));
  if (group.starts_with("link")) return fmt::format("Link {}", xml::escaped(group.substr(4)));
  return xml::escaped(group);
}

/// What a parameter is shown in, and whether that is turned from rad into deg.
struct Unit {
  std::string_view name;
  bool angle = false;
};

/// Every length is called by one letter (x, a, d); the angles are rx, ry, rz and the Greek ones. A joint's
/// deviation is per unit of what it depends on.
Unit unit_of(std::string_view leaf) {
  if (leaf.size() == 1) return {"mm"};
  if (leaf == "scale") return {"mm/m"};
  if (leaf == "gravity") return {"deg/kN m", true};
  if (leaf.starts_with("weight")) return {"deg/m", true};
  return {"deg", true};
}

/// "sin 2q" of "sin2".
std::string harmonic_title(std::string_view leaf) {
  const std::string_view order = leaf.substr(3);
  return fmt::format("{} {}q", leaf.substr(0, 3), order == "1" ? "" : xml::escaped(order));
}

std::string leaf_title(std::string_view leaf) {
  if (leaf == "alpha") return "α";
  if (leaf == "theta") return "θ";
  if (leaf == "beta") return "β";
  if (leaf.starts_with("weight")) return fmt::format("weight at frame {}", xml::escaped(leaf.substr(6)));
  if (leaf.starts_with("sin") || leaf.starts_with("cos")) return harmonic_title(leaf);
  return xml::escaped(leaf);
}

/// What the table of parameters shows beside the values.
struct ParameterColumns {
  bool prior = false, truth = false;

  int count() const { return 7 + (prior ? 1 : 0) + (truth ? 2 : 0); }
};

/// Whether what is known of a parameter comes from a prior to a part that is worth a column.
bool prior_speaks(const Parameter& p) {
  return p.identified.sigma > 0 && p.data_share && *p.data_share < 0.995;
}

std::string_view status_of(const Parameter& p) {
  if (p.identified.identified) return "identified";
  return prior_speaks(p) ? "shared out by the prior" : "kept, by convention";
}

std::string parameter_row(const Parameter& parameter, const ParameterColumns& columns) {
  const IdentifiedParameter& p = parameter.identified;
  const std::string_view name = p.name;
  const std::string_view leaf = name.substr(group_of(name).size() + (name.find('.') == name.npos ? 0 : 1));
  const auto [unit, angle] = unit_of(leaf);
  const auto text = [turned = angle](double value) {
    return turned ? angle_text(value) : length_text(value);
  };
  const bool has_nominal = name.starts_with("link");
  const double sigma = angle ? p.sigma * kDegPerRad : p.sigma;
  std::string html = fmt::format(
      "<tr{}><th scope=\"row\">{}</th><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
      p.identified ? "" : " class=\"convention\"", leaf_title(leaf), unit, has_nominal ? text(p.nominal) : "",
      text(p.value), has_nominal ? text(p.value - p.nominal) : "",
      p.identified || p.sigma > 0 ? sigma_text(sigma) : "");
  if (columns.prior) {
    const bool known = p.sigma > 0 && parameter.data_share;
    html += fmt::format("<td>{}</td>", known ? fmt::format("{:.0f} %", 100 * *parameter.data_share) : "");
  }
  html += fmt::format("<td class=\"text first\">{}</td>", status_of(parameter));
  if (columns.truth) {
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
  if (document.findings.spread) {
    html += fmt::format(" <b>Validation</b>: {}.", validation_text(document));
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
  const Spread* spread = document.findings.spread ? &*document.findings.spread : nullptr;
  if (document.validate) html += stage_rows("Validation", *document.validate, remeasured, spread);
  html += stage_rows("Identification", document.identify, document.validate ? nullptr : remeasured, nullptr);
  return html + "</table></div>\n</section>\n";
}

std::string parameters_section(const ReportDocument& document) {
  if (document.parameters.empty()) return "";
  const ParameterColumns columns{.prior = std::ranges::any_of(document.parameters, prior_speaks),
                                 .truth = std::ranges::any_of(document.parameters, [](const Parameter& p) {
                                   return p.truth.has_value();
                                 })};
  std::string html = fmt::format(
      "<section>\n<h2>Identified parameters</h2>\n<p class=\"note\">The measured positions determine {} of "
      "{} geometric parameters. {}: what they would do, identified ones do in their place, and the "
      "predictions are the "
      "same. σ is one standard deviation.</p>\n",
      document.rank, document.geometric_parameters(),
      document.findings.prior ? "The others are shared out by the prior"
                              : "The others are kept at the data sheet's value by convention");
  if (columns.prior) {
    html +=
        "<p class=\"note\">Where the data share is below 100 %, what is known of the parameter comes in part "
        "from the prior that deviations are small.</p>\n";
  }
  if (columns.truth) {
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
      "<th>value</th><th>deviation</th><th>σ</th>{}<th class=\"first\"></th>{}</tr>\n</thead>\n",
      columns.prior ? "<th>data share</th>" : "",
      columns.truth ? "<th class=\"first\">true value</th><th>value − true</th>" : "");
  std::string_view group;
  for (const Parameter& p : document.parameters) {
    if (const std::string_view own = group_of(p.identified.name); own != group) {
      html +=
          fmt::format("{}<tbody>\n<tr><th class=\"rows\" colspan=\"{}\" scope=\"rowgroup\">{}</th></tr>\n",
                      group.empty() ? "" : "</tbody>\n", columns.count(), group_title(own));
      group = own;
    }
    html += parameter_row(p, columns);
  }
  return html + "</tbody>\n</table></div>\n</section>\n";
}

}  // namespace truepose::report
