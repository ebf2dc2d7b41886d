#include "tools/report/knowledge_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/xml/escape.hpp"
#include "tools/report/findings_text.hpp"
#include "tools/report/heat_map.hpp"
#include "tools/report/number_text.hpp"

namespace truepose::report {
namespace {

std::string sentence_list(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return "";
  std::string html = fmt::format("<h3>{}</h3>\n<ul class=\"sentences\">\n", title);
  for (const std::string& sentence : sentences) html += fmt::format("<li>{}</li>\n", xml::escaped(sentence));
  return html + "</ul>\n";
}

std::string figure(std::string_view name, const std::string& value, std::string_view meaning) {
  return fmt::format(
      "<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"text first meaning\">{}</td></tr>\n", name, value,
      meaning);
}

std::string figures(const ReportDocument& document) {
  const Findings& findings = document.findings;
  std::string html =
      "<h3>How well the poses show the rest</h3>\n<div class=\"scroll\"><table class=\"figures\">\n<tbody>\n";
  html += figure("Rank", fmt::format("{} of {}", document.rank, document.geometric_parameters()),
                 "independent geometric parameters that the positions determine");
  if (findings.rank_gap) {
    html += figure("Gap", fmt::format("{:.2g}", *findings.rank_gap),
                   "smallest pivot kept over the largest dropped: how clear-cut the rank is");
  }
  html += figure("Condition", fmt::format("{:.4g}", document.condition),
                 "largest over smallest singular value, columns at unit norm; below 100 is good");
  if (findings.observability) {
    const Observability& o = *findings.observability;
    const auto number = [](double value) { return fmt::format("{:.3g}", value); };
    html +=
        figure("O1", number(o.o1), "geometric mean of the singular values: volume of the confidence region") +
        figure("O2", number(o.o2), "smallest over largest singular value: roundness of that region") +
        figure("O3", number(o.o3), "smallest singular value: the worst-known combination") +
        figure("O4", number(o.o4), "noise amplification: O2 times O3") +
        figure("O5", number(o.o5), "harmonic sum of the singular values: mean variance");
  }
  return html +
         "</tbody>\n</table></div>\n<p class=\"note\">O1 to O5 compare sets of poses of the same arm; "
         "larger is better.</p>\n";
}

std::string joint_list(const std::vector<double>& joints, const std::set<int>& left_out) {
  std::string text;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    if (left_out.contains(number)) continue;
    text += fmt::format("{}{} at {:.0f}", text.empty() ? "" : ", ", number, joints[i]);
  }
  return text;
}

/// The positions of two joints at every pose that identified, each once.
std::vector<std::pair<double, double>> measured(const ReportDocument& document, int x, int y) {
  std::vector<std::pair<double, double>> marks;
  std::set<int> seen;
  const auto joints = static_cast<std::size_t>(std::max(x, y));
  for (const Point& point : document.points) {
    if (point.set != PoseSet::Identify || point.joints.size() < joints) continue;
    if (!seen.insert(point.pose).second) continue;
    marks.emplace_back(point.joints[static_cast<std::size_t>(x - 1)],
                       point.joints[static_cast<std::size_t>(y - 1)]);
  }
  return marks;
}

/// One scale for all maps, so that they compare.
ColorScale scale_of(const std::vector<UncertaintyMap>& maps) {
  ColorScale scale{std::numeric_limits<double>::infinity(), 0};
  for (const UncertaintyMap& map : maps) {
    for (const std::vector<double>& row : map.sigma_mm) {
      scale.lo = std::min(scale.lo, std::ranges::min(row));
      scale.hi = std::max(scale.hi, std::ranges::max(row));
    }
  }
  return scale;
}

std::string maps(const ReportDocument& document, const Transfer& transfer) {
  if (transfer.maps.empty()) return "";
  const ColorScale scale = scale_of(transfer.maps);
  std::string html = "<div class=\"charts\">\n";
  std::string held;
  for (const UncertaintyMap& map : transfer.maps) {
    html += heat_map_svg({.title = fmt::format("Joints {} and {}", map.x.joint, map.y.joint),
                          .x_label = fmt::format("joint {}", map.x.joint),
                          .y_label = fmt::format("joint {}", map.y.joint),
                          .x_from = map.x.from,
                          .x_to = map.x.to,
                          .y_from = map.y.from,
                          .y_to = map.y.to,
                          .values = map.sigma_mm,
                          .marks = measured(document, map.x.joint, map.y.joint),
                          .scale = scale});
    const std::string others = joint_list(map.held, {map.x.joint, map.y.joint});
    if (others.empty()) continue;
    held += fmt::format(" Over joints {} and {} the others are held, joint {}.", map.x.joint, map.y.joint,
                        others);
  }
  return html + "</div>\n" +
         fmt::format(
             "<p class=\"note\">The joints sweep their limits, one turn at most.{} Circles are the poses "
             "that "
             "identified the arm, with their other joints elsewhere."
             "</p>\n",
             held);
}

}  // namespace

std::string unknown_section(const ReportDocument& document) {
  const Findings& findings = document.findings;
  const std::string prior = prior_text(document);
  if (!findings.observability && prior.empty()) return "";
  std::string html = "<section>\n<h2>What the data cannot tell</h2>\n";
  if (findings.observability) {
    html += sentence_list("Open, whatever the tracker's noise", findings.observability->unknown);
    html += sentence_list("Seen, but known less well than from the data sheet", findings.observability->weak);
  }
  if (!prior.empty()) html += fmt::format("<h3>Prior</h3>\n<p>{}</p>\n", xml::escaped(prior));
  return html + figures(document) + "</section>\n";
}

std::string rejected_section(const ReportDocument& document) {
  const std::vector<Rejected>& rejected = document.findings.rejected;
  if (rejected.empty()) return "";
  std::string html =
      "<section>\n<h2>Points that were rejected</h2>\n<p class=\"note\">The robust loss left them out of the "
      "identification: their error under the model that the others determine is too many standard deviations "
      "of one coordinate. Look for a wrong reflector, a moved mount or a broken beam.</p>\n<div "
      "class=\"scroll\"><table class=\"rejected\">\n<thead>\n<tr><th></th><th>error, mm</th><th>standard "
      "deviations</th></tr>\n</thead>\n<tbody>\n";
  for (const Rejected& point : rejected) {
    html += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{:.0f}</td></tr>\n",
                        xml::escaped(place_text(point)), error_text(point.residual_mm), point.sigmas);
  }
  return html + "</tbody>\n</table></div>\n</section>\n";
}

std::string transfer_section(const ReportDocument& document) {
  if (!document.findings.transfer) return "";
  const Transfer& transfer = *document.findings.transfer;
  std::string html = fmt::format(
      "<section class=\"whole\">\n<h2>How well unmeasured poses are known</h2>\n<p>{} It is worst with joint "
      "{} "
      "(deg, mm for a prismatic joint).</p>\n",
      transfer_text(transfer), joint_list(transfer.worst_joints, {}));
  if (!transfer.warning.empty()) {
    html += fmt::format("<p class=\"caution\">{}</p>\n", xml::escaped(transfer.warning));
  }
  html +=
      "<p class=\"note\">What the noise of the measurements leaves open of the parameters, carried to the "
      "position of the first reflector in the tracker's frame. What the model cannot describe is not in it: "
      "the validation shows that.</p>\n";
  return html + maps(document, transfer) + "</section>\n";
}

}  // namespace truepose::report
