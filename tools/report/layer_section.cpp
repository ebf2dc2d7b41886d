#include "tools/report/layer_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "proto/xml/escape.hpp"
#include "tools/report/findings_text.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {
namespace {

/// Part of the error that a layer takes away, in percent; negative where it adds.
double gain_percent(double without_mm, double with_mm) {
  return without_mm > 0 ? 100 * (1 - with_mm / without_mm) : 0;
}

std::string row(std::string_view name, std::string_view verdict, bool chosen, double without_mm,
                const std::string& with, double gain, std::string_view color) {
  return fmt::format(
      "<tr{}><th scope=\"row\">{}</th><td class=\"text\">{}</td><td class=\"first\">{}</td><td>{}</td>"
      "<td class=\"first\">{:.1f} %</td><td class=\"gain\"><span class=\"bar\"><i style=\"width: {:.2f}%; "
      "background: {}\"></i></span></td></tr>\n",
      chosen ? "" : " class=\"convention\"", xml::escaped(name), verdict, error_text(without_mm), with, gain,
      std::clamp(gain, 0.0, 100.0), color);
}

std::string heading(std::string_view text) {
  return fmt::format("<tbody>\n<tr><th class=\"rows\" colspan=\"6\" scope=\"rowgroup\">{}</th></tr>\n", text);
}

std::string choice_row(const LayerChoice& choice, std::string_view name) {
  const std::string with = choice.standard_error_mm > 0 ? error_text(choice.with_mm, choice.standard_error_mm)
                                                        : error_text(choice.with_mm);
  return row(name, choice.chosen ? "chosen" : "not chosen", choice.chosen, choice.without_mm, with,
             gain_percent(choice.without_mm, choice.with_mm), kLayersColor);
}

std::string geometry_rows(const ReportDocument& document) {
  const Stages& judged = document.judged();
  const double before = judged.before.rms, geometric = judged.geometric.rms;
  return heading(
             fmt::format("Geometry, on the {} points", document.validate ? "validation" : "identification")) +
         row("links of the arm", "fitted", true, before, error_text(geometric),
             gain_percent(before, geometric), kGeometricColor) +
         "</tbody>\n";
}

std::string deviation_rows(const Deviations& deviations) {
  std::string html = heading("Deviations of the joints, cross-validated");
  html += row("all chosen together", "", true, deviations.geometric_mm, error_text(deviations.chosen_mm),
              gain_percent(deviations.geometric_mm, deviations.chosen_mm), kLayersColor);
  for (const LayerChoice& choice : ranked(deviations.groups)) {
    html += choice_row(choice, group_text(choice.name));
  }
  return html + "</tbody>\n";
}

std::string residual_rows(const Residual& residual) {
  std::string html = heading("Field over what is left, cross-validated");
  for (const LayerChoice& choice : ranked(residual.kinds)) {
    html += choice_row(choice, field_text(choice.name));
  }
  return html + "</tbody>\n";
}

}  // namespace

std::string layer_section(const ReportDocument& document) {
  const Findings& findings = document.findings;
  if (!findings.deviations && !findings.residual) return "";
  std::string html =
      "<section>\n<h2>What each layer bought</h2>\n<p class=\"note\">RMS of the 3-D error (mm) without and "
      "with "
      "each part of the model, everything else as chosen. Cross-validated: at poses of the identification "
      "that "
      "the fit had not seen. A part is chosen only where its gain is beyond what chance gives.</p>\n"
      "<div class=\"scroll\"><table class=\"layers\">\n<thead>\n<tr><th></th><th></th><th "
      "class=\"first\">without</th><th>with</th><th class=\"first\">gain</th><th></th></tr>\n</thead>\n";
  html += geometry_rows(document);
  if (findings.deviations) html += deviation_rows(*findings.deviations);
  if (findings.residual) html += residual_rows(*findings.residual);
  return html + "</table></div>\n</section>\n";
}

}  // namespace truepose::report
