#include "core/diagnosis/from_a_row_on.hpp"

#include <algorithm>

#include "core/data/other_units.hpp"
#include "core/diagnosis/change_row.hpp"
#include "core/diagnosis/explanation.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/placement.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {
namespace {

using Points = std::vector<Measurement>;
using ReflectorNames = std::vector<std::string>;

constexpr std::size_t kFewestRows = 8;  // on either side: fewer are outliers, and place no arm
constexpr double kOtherSetUp_mm = 50;   // a tracker that moved by less was bumped
constexpr int kRounds = 3;

bool is_inside(std::size_t row, const Points& rows) {
  return row >= kFewestRows && row + kFewestRows <= rows.size();
}

Points converted(Points rows, double mm) {
  for (Measurement& row : rows) row.p_WS_mm *= mm;
  return rows;
}

/// Rows in another unit: those from a row on, or those before it.
void convert_rows_from(const ReflectorNames& names, double mm, bool later, ModelAndPoints& given) {
  const Points& rows = given.points;
  if (rows.size() < 2 * kFewestRows) return;
  const auto third = static_cast<std::ptrdiff_t>(rows.size() / 3);
  const Points right =
      later ? Points(rows.begin(), rows.begin() + third) : Points(rows.end() - third, rows.end());
  const CalibratedCell cell = placement(given.arm, names, right);
  const Points other = converted(rows, mm);
  const std::vector<double> as_given = misses(cell, rows), in_mm = misses(cell, other);
  const std::size_t row = (later ? change_between(as_given, in_mm) : change_between(in_mm, as_given)).row;
  if (!is_inside(row, rows)) return;
  given.from_row = rows[row].row;
  const auto at = static_cast<std::ptrdiff_t>(row);
  const auto begin = later ? other.begin() + at : other.begin(),
             end = later ? other.end() : other.begin() + at;
  std::copy(begin, end, given.points.begin() + (later ? at : 0));
}

Mistake unit_from_a_row_on(const ReflectorNames& names, const char* unit, double mm, bool later) {
  return {.file = MistakenFile::Measurements,
          .key = "x, y, z",
          .apply_fix = [=](ModelAndPoints& given) { convert_rows_from(names, mm, later, given); },
          .words =
              [=](const RobotModel&, const ModelAndPoints& fixed) {
                const std::string row = std::to_string(fixed.from_row);
                return MistakeWords{later ? "from row " + row + " on the points are in " + unit + ", not mm"
                                          : "before row " + row + " the points are in " + unit +
                                                ", and from row " + row + " on in mm",
                                    "these rows converted"};
              },
          .needs_all_rows = true};
}

/// Brings the rows from another set-up on to where the first one would have seen them.
void join_setups(const ReflectorNames& names, ModelAndPoints& given) {
  const Points& rows = given.points;
  if (rows.size() < 2 * kFewestRows) return;
  const std::size_t third = rows.size() / 3;
  std::size_t ends = third, begins = rows.size() - third;  // of the parts that place the arm
  std::size_t row = 0;
  CalibratedCell first;
  for (int round = 0; round < kRounds; ++round) {
    const auto at = [&](std::size_t i) { return rows.begin() + static_cast<std::ptrdiff_t>(i); };
    first = placement(given.arm, names, Points(rows.begin(), at(ends)));
    const CalibratedCell second = placement(given.arm, names, Points(at(begins), rows.end()));
    row = change_between(misses(first, rows), misses(second, rows)).row;
    if (!is_inside(row, rows)) return;
    ends = begins = row;
  }
  std::vector<Eigen::Vector3d> seen_mm, predicted_mm;
  for (std::size_t i = row; i < rows.size(); ++i) {
    seen_mm.push_back(rows[i].p_WS_mm);
    predicted_mm.push_back(first.predict(rows[i].q, rows[i].smr, rows[i].direction));
  }
  const auto fitted = rigid_fit(seen_mm, predicted_mm);
  if (!fitted) return;
  const Eigen::Isometry3d& X = *fitted;
  if ((X * seen_mm.front() - seen_mm.front()).norm() < kOtherSetUp_mm) return;
  given.from_row = rows[row].row;
  for (std::size_t i = row; i < rows.size(); ++i) given.points[i].p_WS_mm = X * given.points[i].p_WS_mm;
}

}  // namespace

std::vector<Mistake> mistakes_from_a_row_on(std::span<const std::string> smr_names) {
  const ReflectorNames names(smr_names.begin(), smr_names.end());
  std::vector<Mistake> mistakes;
  for (const auto& [unit, mm] : kOtherUnits)
    for (const bool later : {true, false}) mistakes.push_back(unit_from_a_row_on(names, unit, mm, later));
  mistakes.push_back({.file = MistakenFile::Measurements,
                      .key = "x, y, z",
                      .apply_fix = [names](ModelAndPoints& given) { join_setups(names, given); },
                      .words =
                          [](const RobotModel&, const ModelAndPoints& fixed) {
                            return MistakeWords{"from row " + std::to_string(fixed.from_row) +
                                                    " on the points are of another set-up of the tracker",
                                                "these rows as a second --data"};
                          },
                      .needs_all_rows = true,
                      .needs_manual_fix = true});
  return mistakes;
}

}  // namespace truepose
