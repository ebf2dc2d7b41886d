#include "tools/truepose/frame_text.hpp"

#include <algorithm>
#include <cmath>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

using record::FrameDocument;

Cells frame_cells(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
  Cells cells{"mm, deg"};
  for (const double mm : p) cells.push_back(formatted("%.4f", mm));
  for (const double deg : abc) cells.push_back(formatted("%.5f", deg + 0.0));
  return cells;
}

Cells sigma_cells(const Eigen::Vector3d& sigma_mm, const std::optional<Eigen::Vector3d>& sigma_deg) {
  Cells cells{"sigma"};
  for (const double mm : sigma_mm) cells.push_back(formatted("%.4f", mm));
  // Turns about the axes of the outer frame: those of A, B, C have no bound where B is near 90 deg.
  for (Eigen::Index i = 0; i < 3; ++i) cells.push_back(sigma_deg ? formatted("%.5f", (*sigma_deg)[i]) : "-");
  return cells;
}

std::string readings_text(const FrameDocument& frame) {
  const bool turned = std::ranges::any_of(frame.readings, [](const FrameDocument::Reading& reading) {
    return reading.orientation_error_deg.has_value();
  });
  std::vector<Cells> rows{{"row", "point", "off by, mm"}};
  if (turned) rows.front().push_back("turned by, deg");
  for (const FrameDocument::Reading& reading : frame.readings) {
    rows.push_back({std::to_string(reading.row), reading.point, formatted("%.4f", reading.error_mm)});
    if (turned) rows.back().push_back(formatted("%.5f", reading.orientation_error_deg.value_or(0)));
  }
  return text_table(rows);
}

std::string scatter_text(const FrameDocument& frame) {
  if (!frame.sigma0)
    return "No reading is redundant, so the readings are not checked: measure each point more than once.\n";
  double sum = 0;
  for (const FrameDocument::Reading& reading : frame.readings) sum += reading.error_mm * reading.error_mm;
  return formatted("Readings: %.4f mm (RMS) from where all together say, %.1f times their noise.\n",
                   std::sqrt(sum / static_cast<double>(frame.readings.size())), *frame.sigma0);
}

std::string misfit_text(const FrameDocument& frame) {
  std::string text;
  for (const FrameDocument::Point& point : frame.points)
    if (point.residual_mm) text += formatted(" %s %.4f", point.name.c_str(), *point.residual_mm);
  return text.empty() ? text : "Points from their stated coordinates, mm:" + text + "\n";
}

}  // namespace

std::string pose_text(const Eigen::Isometry3d& X, const Eigen::Vector3d& sigma_mm,
                      const std::optional<Eigen::Vector3d>& sigma_deg) {
  return text_table(std::vector<Column>{{-8}, {10, 1}, {10, 1}, {10, 1}, {11, 1}, {11, 1}, {11, 1}},
                    {{"", "X", "Y", "Z", "A", "B", "C"}, frame_cells(X), sigma_cells(sigma_mm, sigma_deg)});
}

std::string frame_text(const FrameDocument& frame) {
  std::string text = formatted("%s %d: %zu readings of %zu points",
                               std::string{name_of(record::kFrameKinds, frame.kind)}.c_str(), frame.number,
                               frame.readings.size(), frame.points.size());
  if (frame.touched_by) text += formatted(", touched by tool %d", *frame.touched_by);
  text += "\n" + pose_text(frame.X, frame.sigma_mm, frame.sigma_deg);
  text += "\n" + readings_text(frame) + "\n" + scatter_text(frame) + misfit_text(frame);
  for (const std::string& note : frame.notes) text += note + "\n";
  return text + frame.krl + "\n";
}

}  // namespace truepose::tools
