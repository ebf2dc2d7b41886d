#include "core/diagnosis/row_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/diagnosis/change_row.hpp"
#include "core/diagnosis/explanation.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/placement.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

using Points = std::vector<Measurement>;
using Names = std::span<const std::string>;

/// Row i measured with the joints of row i + shift.
Measurement paired(const Points& rows, std::size_t i, int shift) {
  Measurement point = rows[i];
  const Measurement& other = rows[static_cast<std::size_t>(static_cast<int>(i) + shift)];
  point.q = other.q;
  point.smr = other.smr;
  return point;
}

bool has_partner(const Points& rows, std::size_t i, int shift, std::size_t first = 0) {
  const int j = static_cast<int>(i) + shift;
  return j >= static_cast<int>(first) && j < static_cast<int>(rows.size());
}

/// The rows from `first` on shifted among themselves, those before it as they are. Rows without a partner are
/// left out.
Points shifted_from(const Points& rows, std::size_t first, int shift) {
  Points points{rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(first)};
  for (std::size_t i = first; i < rows.size(); ++i) {
    if (has_partner(rows, i, shift, first)) points.push_back(paired(rows, i, shift));
  }
  return points;
}

std::string rows_text(int shift) {
  const int rows = std::abs(shift);
  return std::to_string(rows) + (rows == 1 ? " row " : " rows ") + (shift > 0 ? "earlier" : "later");
}

Mistake all_shifted(int shift) {
  const MistakeWords words{"the points stand " + rows_text(shift) + " than their joints", "them moved back"};
  return {
      .file = MistakenFile::Measurements,
      .key = "x, y, z",
      .apply_fix = [shift](ModelAndPoints& given) { given.points = shifted_from(given.points, 0, shift); },
      .words = [words](const RobotModel&, const ModelAndPoints&) { return words; },
      .needs_all_rows = true};
}

// ---- A point or a joint position missing in the middle

constexpr std::size_t kFewestRowsWithGap = 16;
constexpr std::size_t kFewestRowsMoved = 4;  // fewer are outliers

/// The row from which on the rows are better shifted than not, judged by `cell`.
ChangeRow best_gap(const CalibratedCell& cell, const Points& rows, int shift) {
  Points moved = rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (has_partner(rows, i, shift)) moved[i] = paired(rows, i, shift);
  }
  return change_between(misses(cell, rows), misses(cell, moved));
}

/// The gap, searched from both ends of the file, one of them with right rows, and again with all rows fixed.
std::size_t gap_of(const RobotModel& arm, Names names, const Points& rows, int shift) {
  const auto third = static_cast<std::ptrdiff_t>(rows.size() / 3);
  const Points moved = shifted_from(rows, 0, shift);
  ChangeRow gap{.cost = std::numeric_limits<double>::infinity()};
  for (const Points& part :
       {Points{rows.begin(), rows.begin() + third}, Points{moved.end() - third, moved.end()}}) {
    const ChangeRow seen = best_gap(placement(arm, names, part), rows, shift);
    if (seen.cost < gap.cost) gap = seen;
  }
  for (int round = 0; round < 3; ++round)
    gap = best_gap(placement(arm, names, shifted_from(rows, gap.row, shift)), rows, shift);
  return gap.row;
}

Mistake missing_in_the_middle(Names names, int shift) {
  const std::string what = shift > 0 ? "a point" : "a joint position";
  return {.file = MistakenFile::Measurements,
          .key = "x, y, z",
          .apply_fix =
              [names = std::vector<std::string>{names.begin(), names.end()}, shift](ModelAndPoints& given) {
                if (given.points.size() < kFewestRowsWithGap) return;
                const std::size_t first = gap_of(given.arm, names, given.points, shift);
                if (first < kFewestRowsMoved || first + kFewestRowsMoved > given.points.size()) return;
                given.from_row = given.points[first].row;
                given.points = shifted_from(given.points, first, shift);
              },
          .words =
              [what](const RobotModel&, const ModelAndPoints& fixed) {
                return MistakeWords{what + " is missing before row " + std::to_string(fixed.from_row),
                                    "the points moved from there on"};
              },
          .needs_all_rows = true};
}

// ---- Any order

constexpr std::size_t kFewestRowsInAnyOrder = 16;
constexpr std::size_t kMostRowsInAnyOrder = 5000;  // each is compared with each
constexpr std::size_t kPointsToMatch = 60;
constexpr int kPlacementsTried = 200, kPlacementsKept = 5;

/// Rows any of whose joints may belong to any point, and where an arm's flange is with them, wherever it
/// stands.
class AnyRows {
 public:
  AnyRows(const RobotModel& arm, const Points& rows) : rows_{rows}, flange_{flange_poses(arm, rows)} {}

  const std::vector<Eigen::Isometry3d>& flange() const { return flange_; }

  /// Which row's joints put the reflector nearest to each of `points`.
  std::vector<std::size_t> nearest(const CalibratedCell& placed, std::span<const Measurement> points) const {
    const Eigen::Isometry3d X_WB = placed.base.isometry();
    Eigen::Matrix3Xd predicted(3, static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Eigen::Vector3d& p_FS_mm = placed.reflectors[static_cast<std::size_t>(rows_[i].smr)].p_FS_mm;
      predicted.col(static_cast<Eigen::Index>(i)) = transformed(X_WB, transformed(flange_[i], p_FS_mm));
    }
    std::vector<std::size_t> nearest;
    for (const Measurement& point : points) {
      Eigen::Index row = 0;
      (predicted.colwise() - point.p_WS_mm).colwise().squaredNorm().minCoeff(&row);
      nearest.push_back(static_cast<std::size_t>(row));
    }
    return nearest;
  }

  /// The points with the joints that are nearest.
  Points matched(const CalibratedCell& placed, std::span<const Measurement> points) const {
    const std::vector<std::size_t> row = nearest(placed, points);
    Points pairs{points.begin(), points.end()};
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      pairs[k].q = rows_[row[k]].q;
      pairs[k].smr = rows_[row[k]].smr;
    }
    return pairs;
  }

 private:
  const Points& rows_;
  std::vector<Eigen::Isometry3d> flange_;
};

Eigen::Vector3d random_turn(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return random.uniform(0, std::numbers::pi) * Eigen::Vector3d{x, y, z}.normalized();
}

/// A placement that brings the middle of the flange's positions to that of the points, turned at random.
CalibratedCell any_placement(const RobotModel& arm, Names names, const Eigen::Vector3d& middle_B,
                             const Eigen::Vector3d& middle_W, Random& random) {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = rotation_by(random_turn(random));
  X_WB.translation() = middle_W - X_WB.linear() * middle_B;
  CalibratedCell cell{arm, BasePose::of(X_WB), {}};
  for (const std::string& name : names) cell.reflectors.push_back({name, {0, 0, 0}});
  return cell;
}

struct Guess {
  CalibratedCell cell;
  double error_mm = 0;
};

/// Nearest neighbours and the fit to them in turn. Source: Besl, McKay, A method for registration of 3-D
/// shapes, 1992.
void iterate(Guess& guess, Names names, std::span<const Measurement> points, const AnyRows& rows,
             int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const Points pairs = rows.matched(guess.cell, points);
    guess.cell = placement(guess.cell.robot, names, pairs);
    guess.error_mm = median(misses(guess.cell, pairs));
  }
}

/// Where the arm reaches the points best if any row's joints may belong to any point.
CalibratedCell placed_as_sets(const RobotModel& arm, Names names, const Points& rows) {
  Points points;
  const std::size_t count = std::min(rows.size(), kPointsToMatch);
  for (std::size_t k = 0; k < count; ++k) points.push_back(rows[k * rows.size() / count]);
  Eigen::Vector3d middle_B{0, 0, 0}, middle_W{0, 0, 0};
  const AnyRows any{arm, rows};
  for (const Eigen::Isometry3d& X : any.flange()) middle_B += X.translation();
  for (const Measurement& row : rows) middle_W += row.p_WS_mm;
  const double share = 1 / static_cast<double>(rows.size());

  Random random{1};
  std::vector<Guess> guesses;
  for (int k = 0; k < kPlacementsTried; ++k) {
    guesses.push_back({any_placement(arm, names, middle_B * share, middle_W * share, random)});
    iterate(guesses.back(), names, points, any, 2);
  }
  std::ranges::sort(guesses, {}, &Guess::error_mm);
  guesses.resize(kPlacementsKept);
  for (Guess& guess : guesses) iterate(guess, names, points, any, 20);
  return std::ranges::min_element(guesses, {}, &Guess::error_mm)->cell;
}

/// Whether the joints are taken by about as many points as there are: a wrong placement takes few of them
/// many times.
bool taken_evenly(std::vector<std::size_t> taken) {
  const double points = static_cast<double>(taken.size());
  std::ranges::sort(taken);
  const auto repeated = std::ranges::unique(taken);
  return static_cast<double>(repeated.size()) < 0.2 * points;
}

}  // namespace

Mistake unordered_rows(Names names) {
  const MistakeWords words{"the rows of the points are in another order than those of the joints",
                           "each point in the row of the joints that reach it"};
  return {.file = MistakenFile::Measurements,
          .key = "x, y, z",
          .apply_fix =
              [names = std::vector<std::string>{names.begin(), names.end()}](ModelAndPoints& given) {
                const std::size_t rows = given.points.size();
                if (rows < kFewestRowsInAnyOrder || rows > kMostRowsInAnyOrder) return;
                const CalibratedCell rough = placed_as_sets(given.arm, names, given.points);
                const AnyRows any{given.arm, given.points};
                if (!taken_evenly(any.nearest(rough, given.points))) return;
                const ModelAndPoints first{given.arm, any.matched(rough, given.points), {}};
                const CalibratedCell explained = explanation(first, placed(first, names)).cell;
                given.points = AnyRows{explained.robot, given.points}.matched(explained, given.points);
              },
          .words = [words](const RobotModel&, const ModelAndPoints&) { return words; },
          .needs_all_rows = true};
}

std::vector<Mistake> row_order_mistakes(Names names) {
  const auto reflectors = static_cast<int>(names.size());
  constexpr int kMostRows = 3;
  std::vector<int> shifts;
  for (int rows = 1; rows <= kMostRows; ++rows) {
    for (const int unit : {1, reflectors}) {
      for (const int shift : {rows * unit, -rows * unit}) {
        if (std::ranges::find(shifts, shift) == shifts.end()) shifts.push_back(shift);
      }
    }
  }
  std::vector<Mistake> mistakes;
  for (const int shift : shifts) mistakes.push_back(all_shifted(shift));
  for (const int shift : shifts) {
    if (std::abs(shift) == 1 || std::abs(shift) == reflectors)
      mistakes.push_back(missing_in_the_middle(names, shift));
  }
  return mistakes;
}

}  // namespace truepose
