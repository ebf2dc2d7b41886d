#pragma once

#include <optional>
#include <string>
#include <vector>

namespace truepose::report {

/// What was done for one target: what was added to each joint (deg or mm), and what is left.
struct CompensationRow {
  double residual_mm = 0;
  double residual_deg = 0;
  std::optional<double> sigma_mm;
  bool damped = false;
  std::vector<double> corrections;
};

struct CompensationReport {
  std::string robot, targets;  ///< names
  bool position_only = false;
  std::vector<CompensationRow> rows;  ///< at least one, all with as many corrections
};

/// One XHTML page that stands alone: corrections, residuals and standard deviations over the targets. Of very
/// many targets every k-th is drawn.
std::string render_compensation_html(const CompensationReport& report);

}  // namespace truepose::report
