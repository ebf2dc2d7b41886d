#include "tools/report/summary_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "core/math/statistics.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {
namespace {

std::string plural(long long n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
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
  if (const std::size_t rejected = document.findings.rejected.size(); rejected > 0) {
    html +=
        badge(false, plural(static_cast<long long>(rejected), "point was rejected", "points were rejected"));
  }
  if (const std::size_t skipped = document.setup.skipped.size(); skipped > 0) {
    html += badge(false, plural(static_cast<long long>(skipped), "pose was skipped", "poses were skipped"));
  }
  if (document.stream) {
    const Stream& s = *document.stream;
    const long long unanswered = s.cycles - s.answered - s.unproven;
    const bool clean = unanswered == 0 && s.late == 0 && s.wrong_ipoc == 0;
    const std::string but = s.unproven == 0 ? ""
                                            : fmt::format(", but the first {} of {}", s.unproven,
                                                          plural(s.sessions, "session", "sessions"));
    html += badge(clean, clean ? "Every stream cycle answered in time" + but
                               : fmt::format("Stream: {} late, {} unanswered", s.late, unanswered));
  }
  return html + "</ul>\n";
}

/// Judged points whose error after all layers is far beyond the usual one.
long long points_far_off(const ReportDocument& document) {
  constexpr double kMedians = 10;
  std::vector<double> errors;
  for (const Point& p : document.judged_points()) errors.push_back(p.after.norm());
  const double limit = kMedians * median(errors);
  return std::ranges::count_if(errors, [limit](double error) { return error > limit; });
}

std::string_view points_text(const ReportDocument& document) {
  if (document.cross_validated()) return "each predicted by a fit that had not seen it";
  return document.validate ? "that took no part in the identification" : "that the parameters were fitted to";
}

std::string before_and_after(const ReportDocument& document) {
  const Stages& judged = document.judged();
  const double before = judged.before.mean, after = document.achieved().mean;
  return fmt::format(
      "<p>On {} {} the mean error went from {}&#160;mm to {}&#160;mm, the largest from {}&#160;mm to "
      "{}&#160;mm{}.</p>\n",
      plural(judged.points, "point", "points"), points_text(document), error_text(before), error_text(after),
      error_text(judged.before.max), error_text(document.achieved().max),
      document.remeasured ? ", measured again with compensated joints" : "");
}

std::string bars(const ReportDocument& document) {
  const Stages& judged = document.judged();
  const double before = judged.before.mean, after = document.achieved().mean;
  const double longest = std::max({before, judged.geometric.mean, judged.after.mean, after});
  std::string html = "<div class=\"bars\">\n" + bar("Before", kBeforeColor, before, longest) +
                     bar("Geometric", kGeometricColor, judged.geometric.mean, longest);
  if (has_layers(judged)) html += bar("All layers", kLayersColor, judged.after.mean, longest);
  if (document.remeasured) html += bar("Compensated", kCompensatedColor, after, longest);
  return html + "</div>\n";
}

std::string_view class_of(Verdict::Kind kind) {
  switch (kind) {
    case Verdict::Kind::Use:
      return "use";
    case Verdict::Kind::Caution:
      return "caution";
    case Verdict::Kind::Refuse:
      return "refuse";
  }
  return {};
}

}  // namespace

Verdict verdict_of(const ReportDocument& document) {
  using enum Verdict::Kind;
  if (!document.converged)
    return {Refuse,
            "Do not use this model: the identification did not converge. Check the robot file and the "
            "measurements, and identify again."};
  if (!document.improved())
    return {
        Refuse,
        "Do not use this model: the arm it describes is no nearer to the measurements than the data "
        "sheet's. Check the robot file, the mounting of the reflector and the tracker, and measure again."};
  if (!document.validate)
    return {Caution,
            "Do not rely on this model yet: nothing but the points it was fitted to shows how good it is. "
            "Measure more poses and validate on them."};
  if (const auto& transfer = document.findings.transfer; transfer && !transfer->warning.empty())
    return {Caution,
            "Use this model only where poses were measured: elsewhere it may be worse than the data sheet. "
            "Measure more poses, spread over the workspace, to use it everywhere."};
  if (const long long far = points_far_off(document); far > 0)
    return {Caution,
            fmt::format(
                "Look first at the {} farther off than ten times the usual error: {} wrongly measured, or "
                "the model does not hold there. Measure {} again before you use it.",
                plural(far, "point that is", "points that are"), far == 1 ? "it was" : "they were",
                far == 1 ? "it" : "them")};
  if (document.remeasured)
    return {Use,
            "Use this model: the arm was driven by it to poses it had not seen, and measured there again."};
  return {Use,
          "Use this model: it predicts poses that it had not seen. Measure some of them again with "
          "compensated joints to prove it on the arm."};
}

std::string summary_section(const ReportDocument& document) {
  const double before = document.judged().before.mean, after = document.achieved().mean;
  const Verdict verdict = verdict_of(document);
  return fmt::format(
             "<section class=\"summary\">\n<p class=\"eyebrow\">Mean position error</p>\n<p "
             "class=\"headline\"><span "
             "class=\"was\">{} <small>mm</small></span><span class=\"arrow\">→</span><span class=\"{}\">{} "
             "<small>mm</small></span><span class=\"factor\">{}</span></p>\n",
             error_text(before), document.improved() ? "now" : "was", error_text(after),
             document.improved() ? factor_text(before, after) + " times more accurate" : "no improvement") +
         fmt::format("<p class=\"verdict {}\">{}</p>\n", class_of(verdict.kind),
                     xml::escaped(verdict.sentence)) +
         before_and_after(document) + bars(document) + badges(document) + "</section>\n";
}

}  // namespace truepose::report
