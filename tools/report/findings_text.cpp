#include "tools/report/findings_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "core/math/angles.hpp"
#include "tools/report/number_text.hpp"

namespace truepose::report {
namespace {

std::string deviations_text(const Findings& findings) {
  if (!findings.deviations) return {};
  const Deviations& deviations = *findings.deviations;
  std::string groups;
  for (const LayerChoice& group : ranked(deviations.groups)) {
    if (!group.chosen) continue;
    groups += fmt::format("  without {:<22}{:>8} mm, {:.1f} % more\n", group_text(group.name),
                          error_text(group.without_mm), 100 * (group.without_mm / group.with_mm - 1));
  }
  if (groups.empty()) return "\nJoint deviations: none predicts unseen poses better.\n";
  return fmt::format("\nJoint deviations: cross-validated RMS {} mm -> {} mm\n",
                     error_text(deviations.geometric_mm), error_text(deviations.chosen_mm)) +
         groups;
}

std::string residual_text(const Findings& findings) {
  if (!findings.residual) return {};
  for (const LayerChoice& kind : findings.residual->kinds) {
    if (!kind.chosen) continue;
    return fmt::format("\nResidual field: {}, cross-validated RMS {} mm -> {} mm\n", field_text(kind.name),
                       error_text(kind.without_mm), error_text(kind.with_mm, kind.standard_error_mm));
  }
  return "\nResidual field: none predicts unseen poses better.\n";
}

std::string rejected_text(const Findings& findings) {
  constexpr std::size_t kListed = 10;
  std::vector<Rejected> points = findings.rejected;
  if (points.empty()) return {};
  std::ranges::stable_sort(points, std::ranges::greater{}, &Rejected::sigmas);
  std::string text =
      fmt::format("\nRejected points: {}{}\n", points.size(),
                  points.size() > kListed ? fmt::format(", the worst {} of them", kListed) : "");
  points.resize(std::min(points.size(), kListed));
  for (const Rejected& point : points) {
    text += fmt::format("  {}: {} mm, {:.0f} standard deviations\n", place_text(point),
                        error_text(point.residual_mm), point.sigmas);
  }
  return text;
}

std::string sentences_text(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {};
  std::string text = fmt::format("\n{}:\n", title);
  for (const std::string& sentence : sentences) text += "  " + sentence + "\n";
  return text;
}

}  // namespace

std::string group_text(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos || !name.starts_with("joint")) return std::string(name);
  std::string_view kind = name.substr(dot + 1);
  const std::string joint = fmt::format("joint {}, ", name.substr(5, dot - 5));
  if (kind.starts_with("harmonic")) return joint + fmt::format("harmonic {}", kind.substr(8));
  return joint + std::string(kind);
}

std::string field_text(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kFields{
      {{"gp", "Gaussian process"},
       {"kriging", "kriging"},
       {"idw", "inverse distance"},
       {"mls", "moving least squares"},
       {"nn", "neural network"}}};
  for (const auto& [field, text] : kFields) {
    if (field == name) return std::string(text);
  }
  return std::string(name);
}

std::string place_text(const Rejected& point) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (point.pose > 0) add(fmt::format("pose {}", point.pose));
  if (!point.smr.empty()) add("reflector " + point.smr);
  if (point.row > 0) add(fmt::format("row {}", point.row));
  return text;
}

std::string validation_text(const ReportDocument& document) {
  if (!document.findings.spread) return {};
  const Spread& spread = *document.findings.spread;
  if (!document.cross_validated())
    return fmt::format("mean ± standard deviation over {} splits", spread.count);
  return fmt::format(
      "each pose predicted by the one of {} fits that had not seen it (± standard deviation "
      "over the folds)",
      spread.count);
}

std::string prior_text(const ReportDocument& document) {
  if (!document.findings.prior) return {};
  const PriorScale& prior = *document.findings.prior;
  double from_prior = 0;
  int links = 0, mostly = 0;
  for (const Parameter& p : document.parameters) {
    if (!p.identified.name.starts_with("link") || !p.data_share) continue;
    ++links;
    from_prior += 1 - *p.data_share;
    mostly += *p.data_share < 0.5;
  }
  std::string text = fmt::format(
      "The poses do not show all link errors well, so these were taken as small ({} mm, {} deg, one standard "
      "deviation) before they were measured.",
      sigma_text(prior.length_mm), sigma_text(prior.angle_rad * kDegPerRad));
  if (links > 0) {
    text += fmt::format(
        " This prior makes up {:.0f} % of what is known of them, and more than half of it for {} of {} link "
        "parameters.",
        100 * from_prior / links, mostly, links);
  }
  return text;
}

std::string transfer_text(const Transfer& transfer) {
  return fmt::format(
      "The position of an unmeasured pose is predicted with a standard deviation of {} mm (RMS over the "
      "joint "
      "limits), {} mm at worst.",
      sigma_text(transfer.rms_mm), sigma_text(transfer.max_mm));
}

std::string findings_text(const ReportDocument& document) {
  const Findings& findings = document.findings;
  std::string text = deviations_text(findings) + residual_text(findings) + rejected_text(findings);
  if (findings.observability) {
    text += sentences_text("What the poses cannot tell", findings.observability->unknown) +
            sentences_text("What the data sheet knows better", findings.observability->weak);
  }
  if (const std::string prior = prior_text(document); !prior.empty()) text += "\n" + prior + "\n";
  if (findings.transfer) {
    text += fmt::format("\n{}\n", transfer_text(*findings.transfer));
    if (!findings.transfer->warning.empty()) text += fmt::format("Warning: {}\n", findings.transfer->warning);
  }
  return text;
}

}  // namespace truepose::report
