#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/math/statistics.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/text/message.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr std::array kVerdictClasses{"use", "caution", "refuse"};  // of Verdict::Kind

std::string plural(long long n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string badge(bool good, std::string_view text) {
  return fmt::format("<li{}>{}</li>\n", good ? "" : " class=\"warning\"", text);
}

/// A badge of something that went wrong so many times; none for never.
std::string badge_of_count(std::size_t count, std::string_view one, std::string_view many) {
  return count == 0 ? "" : badge(false, plural(static_cast<long long>(count), one, many));
}

std::string validation_badge(const ReportDocument& document) {
  if (!document.validate) return badge(false, "Not validated: the figures are those of the fitted points");
  const int poses = document.validate->poses;
  if (document.cross_validated())
    return badge(true, fmt::format("Cross-validated on {} poses in {} folds", poses, document.spread->count));
  return badge(true, "Validated on " + plural(poses, "separate pose", "separate poses"));
}

std::string stream_badge(const std::optional<record::Stream>& stream) {
  if (!stream) return "";
  const std::int64_t unanswered = stream->cycles - stream->answered - stream->unconfirmed;
  if (unanswered != 0 || stream->late != 0 || stream->wrong_ipoc != 0)
    return badge(false, fmt::format("Stream: {} late, {} unanswered", stream->late, unanswered));
  const std::string but = stream->unconfirmed == 0
                              ? ""
                              : fmt::format(", but the first {} of {}", stream->unconfirmed,
                                            plural(stream->sessions, "session", "sessions"));
  return badge(true, "Every stream cycle answered in time" + but);
}

std::string badges(const ReportDocument& document) {
  std::string html = "<ul class=\"badges\">\n";
  html +=
      document.converged ? badge(true, "Converged") : badge(false, "Not converged: do not use this model");
  html += validation_badge(document);
  if (document.remeasured) html += badge(true, "Compensated poses measured again");
  if (document.prediction_uncertainty && !document.prediction_uncertainty->warning.empty())
    html += badge(false, "Not known well everywhere: measure more poses");
  html += badge_of_count(document.rejected.size(), "point was left out", "points were left out") +
          badge_of_count(document.validation_outliers.size(), "validation point is beyond six sigma",
                         "validation points are beyond six sigma") +
          badge_of_count(document.skipped ? document.skipped->size() : 0, "pose was skipped",
                         "poses were skipped") +
          stream_badge(document.stream);
  return html + "</ul>\n";
}

std::string_view points_text(const ReportDocument& document) {
  if (document.cross_validated()) return "each predicted by a fit that had not seen it";
  return document.validate ? "that took no part in the identification" : "that the parameters were fitted to";
}

std::string before_and_after(const ReportDocument& document) {
  const StageErrors& judged = document.judged();
  const double before = judged.before.mean, after = document.achieved().mean;
  return fmt::format(
      "<p>On {} {} the mean error went from {}&#160;mm to {}&#160;mm, the largest from {}&#160;mm to "
      "{}&#160;mm{}. This accuracy holds for the reflector: where a tool's TCP is on the flange was not "
      "measured with it. Taken from a drawing, a TCP may be off by more than half a millimetre; <code>truepose "
      "tool</code> measures it.</p>\n",
      plural(judged.points, "point", "points"), points_text(document), error_text(before), error_text(after),
      error_text(judged.before.max), error_text(document.achieved().max),
      document.remeasured ? ", measured again with compensated joints" : "");
}

std::string bars(const ReportDocument& document) {
  const std::vector<Stage> stages = stages_of(document, document.judging());
  double longest_mm = 0;
  for (const Stage& stage : stages) longest_mm = std::max(longest_mm, stage.errors->mean);
  std::string html = "<div class=\"bars\">\n";
  for (const Stage& stage : stages) {
    const double mm = stage.errors->mean;
    html += fmt::format("<span>{}</span>{}<b>{} mm</b>\n", stage.name,
                        bar(longest_mm > 0 ? 100 * mm / longest_mm : 0, stage.color), error_text(mm));
  }
  return html + "</div>\n";
}

}  // namespace

std::string verdict_heading(const ReportDocument& document) {
  switch (document.verdict->color()) {
    case VerdictColor::Red:
      return "Do not use this model";
    case VerdictColor::Amber:
      return "Look into this before you use the model";
    case VerdictColor::Green:
      break;
  }
  if (document.remeasured)
    return "Use this model: the arm was driven by it to poses it had not seen, and measured there again";
  return "Use this model: it predicts poses that it had not seen. Measure some of them again with compensated "
         "joints to prove it on the arm";
}

Verdict verdict_of(const ReportDocument& document) {
  constexpr std::array kKinds{Verdict::Kind::Use, Verdict::Kind::Caution, Verdict::Kind::Refuse};
  const VerdictColor color = document.verdict->color();
  const auto& production = document.production;
  if (color != VerdictColor::Red && production && production->accuracy.refuted())
    return production_verdict(*production);
  std::string sentence = verdict_heading(document) + ".";
  AnswerText answer;
  for (const Finding& found : document.verdict->findings)
    sentence += " " + with_capital(answer.add({found.code, found.sentence, found.what_to_do}));
  return {kKinds[static_cast<std::size_t>(color)], sentence};
}

std::string verdict_paragraph(const Verdict& verdict) {
  return fmt::format("<p class=\"verdict {}\">{}</p>\n",
                     kVerdictClasses[static_cast<std::size_t>(verdict.kind)], xml::escaped(verdict.sentence));
}

std::string summary_section(const ReportDocument& document) {
  const std::string headline = fmt::format(
      "<p class=\"eyebrow\">Mean position error</p>\n<p class=\"headline\"><span class=\"was\">{} "
      "<small>mm</small></span><span class=\"arrow\">→</span><span class=\"{}\">{} "
      "<small>mm</small></span><span class=\"factor\">{}</span></p>\n{}",
      error_text(document.judged().before.mean), document.improved() ? "now" : "was",
      error_text(document.achieved().mean), improvement_text(document),
      verdict_paragraph(verdict_of(document)));
  return section("", headline + before_and_after(document) + bars(document) + badges(document), "summary");
}

}  // namespace truepose::report
