#include "core/quality/splits_verdict.hpp"

#include <algorithm>
#include <cinttypes>
#include <string>
#include <utility>

#include "core/formatted.hpp"

namespace truepose {
namespace {

using Splits = std::span<const JudgedSplit>;
using Finds = std::optional<Finding>;

Severity gravest(const JudgedSplit& split) {
  return split.verdict.findings.empty() ? Severity::Note : split.verdict.findings.front().severity;
}

std::string share_of(std::ptrdiff_t count, Splits splits) {
  return formatted("%td of the %zu splits", count, splits.size());
}

Finds beyond_tolerance(Splits splits, const std::optional<double>& tolerance_mm) {
  if (!tolerance_mm) return std::nullopt;
  const auto beyond = std::ranges::count_if(
      splits, [&](const JudgedSplit& split) { return split.largest_mm > *tolerance_mm; });
  if (beyond == 0) return std::nullopt;
  const JudgedSplit& worst = *std::ranges::max_element(splits, {}, &JudgedSplit::largest_mm);
  return finding(
      FindingKind::SplitsTolerance,
      "errors of " + share_of(beyond, splits) +
          formatted(" are beyond the tolerance of %.3f mm, the largest, %.3f mm, in that of seed %" PRIu64,
                    *tolerance_mm, worst.largest_mm, worst.seed));
}

/// Findings of other splits that the first split does not have.
///
/// @param kind     of the gravest finding of those that count it has the severity
/// @param do_what  "refuse the model"
Finds findings_of_other_splits(Splits splits, FindingKind kind, const std::string& do_what) {
  const Severity severity = row_of(kind).severity;
  const std::vector<Finding>& of_first = splits.front().verdict.findings;
  const auto has = [&](const JudgedSplit& split) { return gravest(split) == severity; };
  const auto other = std::ranges::find_if(splits.subspan(1), [&](const JudgedSplit& split) {
    return has(split) &&
           !std::ranges::count(of_first, split.verdict.findings.front().sentence, &Finding::sentence);
  });
  if (other == splits.subspan(1).end()) return std::nullopt;
  return finding(kind, share_of(std::ranges::count_if(splits, has), splits) + " " + do_what +
                           formatted(", that of seed %" PRIu64 ": ", other->seed) +
                           other->verdict.findings.front().sentence);
}

/// So many raise doubts as chance alone does not.
Finds warnings_of_other_splits(Splits splits) {
  const Finds found = findings_of_other_splits(splits, FindingKind::SplitsDoubted, "raise doubts");
  const auto doubted = std::ranges::count(splits, Severity::Warning, gravest);
  if (!found || 2 * doubted > std::ssize(splits)) return found;
  return finding(FindingKind::SplitsDoubtedSome, found->sentence);
}

}  // namespace

CalibrationVerdict verdict_over_splits(Splits splits, std::optional<double> tolerance_mm) {
  CalibrationVerdict verdict = splits.front().verdict;
  for (Finds found : {beyond_tolerance(splits, tolerance_mm),
                      findings_of_other_splits(splits, FindingKind::SplitsRefused, "refuse the model"),
                      warnings_of_other_splits(splits)})
    if (found) verdict.findings.push_back(*std::move(found));
  std::ranges::stable_sort(verdict.findings, std::ranges::greater{}, &Finding::severity);
  return verdict;
}

}  // namespace truepose
