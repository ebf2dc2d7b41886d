#include "tools/report/report_html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "proto/xml/escape.hpp"
#include "tools/report/knowledge_sections.hpp"
#include "tools/report/layer_section.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_charts.hpp"
#include "tools/report/report_document.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/report_tables.hpp"

namespace truepose::report {
namespace {

std::string plural(long long n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string header(const ReportDocument& document) {
  std::string identity;
  for (const std::string& part : {document.tracker, document.campaign}) {
    if (part.empty()) continue;
    if (!identity.empty()) identity += " · ";
    identity += xml::escaped(part);
  }
  std::string html = fmt::format("<header>\n<p class=\"eyebrow\">Calibration report</p>\n<h1>{}</h1>\n",
                                 document.robot.empty() ? "Robot arm" : xml::escaped(document.robot));
  if (!identity.empty()) html += fmt::format("<p class=\"identity\">{}</p>\n", identity);
  return html + "</header>\n";
}

std::string bar(std::string_view name, std::string_view color, double mm, double longest_mm) {
  const double percent = longest_mm > 0 ? 100 * mm / longest_mm : 0;
  return fmt::format(
      "<span>{}</span><span class=\"bar\"><i style=\"width: {:.2f}%; background: {}\"></i></span><b>{} "
      "mm</b>\n",
      name, percent, color, error_text(mm));
}

std::string badge(bool good, std::string_view text) {
  return fmt::format("<li{}>{}</li>\n", good ? "" : " class=\"warning\"", text);
}

std::string validation_badge(const ReportDocument& document) {
  if (!document.validate) return badge(false, "Not validated: the figures are those of the fitted points");
  const int poses = document.validate->poses;
  if (document.cross_validated())
    return badge(
        true, fmt::format("Cross-validated on {} poses in {} folds", poses, document.findings.spread->count));
  return badge(true, "Validated on " + plural(poses, "separate pose", "separate poses"));
}

std::string badges(const ReportDocument& document) {
  std::string html = "<ul class=\"badges\">\n";
  html +=
      document.converged ? badge(true, "Converged") : badge(false, "Not converged: do not use this model");
  html += validation_badge(document);
  if (document.remeasured) html += badge(true, "Compensated poses measured again");
  if (const auto& transfer = document.findings.transfer; transfer && !transfer->warning.empty()) {
    html += badge(false, "Not known well everywhere: measure more poses");
  }
  if (document.stream) {
    const Stream& s = *document.stream;
    const bool clean = s.answered == s.cycles && s.late == 0 && s.wrong_ipoc == 0;
    html +=
        badge(clean, clean ? "Every stream cycle answered in time"
                           : fmt::format("Stream: {} late, {} unanswered", s.late, s.cycles - s.answered));
  }
  return html + "</ul>\n";
}

std::string_view points_text(const ReportDocument& document) {
  if (document.cross_validated()) return "each predicted by a fit that had not seen it";
  return document.validate ? "that took no part in the identification" : "that the parameters were fitted to";
}

std::string summary(const ReportDocument& document) {
  const Stages& judged = document.judged();
  const double before = judged.before.mean, after = document.achieved().mean;
  const bool better = after < before;
  std::string html = fmt::format(
      "<section class=\"summary\">\n<p class=\"eyebrow\">Mean position error</p>\n<p "
      "class=\"headline\"><span "
      "class=\"was\">{} <small>mm</small></span><span class=\"arrow\">→</span><span class=\"{}\">{} "
      "<small>mm</small></span><span class=\"factor\">{}</span></p>\n",
      error_text(before), better ? "now" : "was", error_text(after),
      better ? factor_text(before, after) + " times more accurate" : "no improvement: do not use this model");
  html += fmt::format(
      "<p>On {} {} the mean error went from {} mm to {} mm, the largest from {} mm to {} mm{}.</p>\n",
      plural(judged.points, "point", "points"), points_text(document), error_text(before), error_text(after),
      error_text(judged.before.max), error_text(document.achieved().max),
      document.remeasured ? ", measured again with compensated joints" : "");

  const double longest = std::max({before, judged.geometric.mean, judged.after.mean, after});
  html += "<div class=\"bars\">\n" + bar("Before", kBeforeColor, before, longest) +
          bar("Geometric", kGeometricColor, judged.geometric.mean, longest);
  if (has_layers(judged)) html += bar("All layers", kLayersColor, judged.after.mean, longest);
  if (document.remeasured) html += bar("Compensated", kCompensatedColor, after, longest);
  return html + "</div>\n" + badges(document) + "</section>\n";
}

std::string footer() {
  return fmt::format("<footer>Written by truepose {}. Lengths in mm, angles in degrees.</footer>\n",
                     TRUEPOSE_VERSION);
}

}  // namespace

std::string render_html(const boost::json::object& json) {
  const ReportDocument document = read_document(json);
  const std::string title =
      document.robot.empty() ? "Calibration report" : xml::escaped(document.robot) + ": calibration report";
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
      "charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n<main>\n",
      title, kStyleSheet);
  html += header(document) + summary(document) + statistics_section(document) + layer_section(document) +
          transfer_section(document) + rejected_section(document) + histogram_section(document) +
          point_sections(document) + parameters_section(document) + unknown_section(document) +
          stream_section(document) + conditions_section(document) + footer();
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace truepose::report
