#include "core/diagnosis/mistaken_points.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/diagnosis/unit_mistakes.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kHopeless_mm = 10;
constexpr double kLeftOfError = 0.02;  // of the error, that may be left
constexpr int kFewestMistaken = 3;     // rows that have to be left of such

double middle_error_mm(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<double> errors_mm;
  for (const Measurement& point : points) errors_mm.push_back((cell.predict(point) - point.p_WS_mm).norm());
  return median(errors_mm);
}

/// Each joint position with the point that stands `rows` below it.
std::vector<Measurement> shifted(std::span<const Measurement> points, int rows) {
  std::vector<Measurement> moved;
  for (int i = 0; i < std::ssize(points); ++i) {
    const int from = i + rows;
    if (from < 0 || from >= std::ssize(points)) continue;
    Measurement point = points[static_cast<std::size_t>(from)];
    point.q = points[static_cast<std::size_t>(i)].q;
    moved.push_back(std::move(point));
  }
  return moved;
}

std::optional<std::string> wrong_columns(const CalibratedCell& cell, std::span<const Measurement> points,
                                         double most_mm) {
  const ModelAndPoints given{.arm = cell.robot, .points{points.begin(), points.end()}, .open = {}};
  std::vector<Mistake> mistakes = measurement_unit_mistakes(cell.robot);
  std::ranges::move(column_mistakes(cell.robot), std::back_inserter(mistakes));
  for (const Mistake& mistake : mistakes) {
    if (mistake.file != MistakenFile::Measurements) continue;
    ModelAndPoints fixed = given;
    mistake.apply_fix(fixed);
    if (middle_error_mm(cell, fixed.points) < most_mm) return mistake.words(cell.robot, fixed).wrong;
  }
  return std::nullopt;
}

std::optional<std::string> wrong_rows(const CalibratedCell& cell, std::span<const Measurement> points,
                                      double most_mm) {
  for (const int rows : {1, -1, 2, -2}) {
    const std::vector<Measurement> moved = shifted(points, rows);
    if (std::ssize(moved) < kFewestMistaken || middle_error_mm(cell, moved) >= most_mm) continue;
    return std::string("the joint positions stand ") + (std::abs(rows) == 1 ? "a row" : "two rows") +
           (rows > 0 ? " above" : " below") + " their points";
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> mistaken_points(const CalibratedCell& cell, std::span<const Measurement> points) {
  const double error_mm = middle_error_mm(cell, points);
  if (error_mm < kHopeless_mm) return std::nullopt;
  if (auto columns = wrong_columns(cell, points, kLeftOfError * error_mm)) return columns;
  return wrong_rows(cell, points, kLeftOfError * error_mm);
}

}  // namespace truepose
