#include "core/diagnosis/model_sanity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/data/error_bounds.hpp"
#include "core/diagnosis/diagnosis.hpp"
#include "core/diagnosis/failure_pattern.hpp"
#include "core/diagnosis/mistake_search.hpp"
#include "core/diagnosis/reflector_labels.hpp"
#include "core/diagnosis/row_order.hpp"
#include "core/diagnosis/unit_mistakes.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kDeviates_mm = 5;             // up to here an arm may merely deviate
constexpr double kBetter = 2;                  // times: smallest improvement by the fix of a gross mistake
constexpr double kBetterIdentified = 1.3;      // times: the same of a hidden one
constexpr double kBetterOfSeveral = 5;         // times: reflectors whose names are exchanged
constexpr std::size_t kPosesToJudge = 8;       // with fewer, chance and a failed fit explain as much
constexpr std::size_t kPoses = 40;             // tell a gross mistake as well as more would
constexpr std::size_t kPosesToIdentify = 150;  // tell a hidden one
constexpr double kExplained = 0.1;             // what is left of the error once the links are identified
constexpr double kManyGrossErrors =
    0.25;  // part of the points: without a reason no arm is refused for so few
constexpr double kMostLeftOfSpread = 0.1;  // with more, units that the magnitudes show are looked at
constexpr double kHides = 3;  // times: what a hidden mistake may leave with base and reflectors alone

using Points = std::vector<Measurement>;

std::string mm_text(double mm) {
  const int decimals = mm < 1 ? 2 : mm < 10 ? 1 : 0;
  return formatted("%.*f mm", decimals, mm);
}

ProbableCause with_errors(ProbableCause cause, double error_mm, const char* which) {
  cause.error_mm = error_mm;
  cause.sentence += std::string(" the ") + which + " error falls from " + mm_text(error_mm) + " to " +
                    mm_text(cause.fixed_mm);
  return cause;
}

ProbableCause cause_of(const Hypothesis& hypothesis, const RobotModel& nominal, const MeasurementData& data) {
  ModelAndPoints fixed{.arm = nominal, .points = data.points, .open = {}};
  for (const Mistake& mistake : hypothesis.mistakes) mistake.apply_fix(fixed);
  return {.sentence = hypothesis.sentence(nominal),
          .mistakes = hypothesis.mistakes,
          .fixed_arm = hypothesis.fixed.arm,
          .fixed_points = std::move(fixed.points),
          .others = {}};
}

ProbableCause cause_of(const std::vector<Hypothesis>& explaining, const RobotModel& nominal,
                       const MeasurementData& data) {
  ProbableCause cause = cause_of(explaining.front(), nominal, data);
  for (std::size_t k = 1; k < explaining.size(); ++k)
    cause.others.push_back(cause_of(explaining[k], nominal, data));
  return cause;
}

/// With the errors that base and reflectors alone leave, where they are more than an arm's that merely
/// deviates; where these hardly fall those of the links fitted too; where the links make up for a mistake, as
/// the d of parallel axes do for each other, with how far they are off for that; or else with how many points
/// fit nowhere, which the middle one does not show; nothing where none falls.
std::optional<ProbableCause> probable_cause(const std::vector<Hypothesis>& explaining,
                                            const Diagnosis& diagnosis, const RobotModel& nominal,
                                            const MeasurementData& data) {
  if (explaining.empty()) return std::nullopt;
  const Explanation& given = diagnosis.as_given().explanation;
  const Explanation& fixed = explaining.front().explanation;
  ProbableCause cause = cause_of(explaining, nominal, data);
  cause.error_mm = given.error_mm();
  cause.fixed_mm = fixed.error_mm();
  if (given.coarse_mm > kDeviates_mm && fixed.coarse_mm < given.coarse_mm / kBetter) {
    cause.fixed_mm = fixed.coarse_mm;
    return with_errors(std::move(cause), given.coarse_mm, "coarse");
  }
  if (fixed.error_mm() < given.error_mm() / kBetterIdentified &&
      fixed.error_mm() < given.error_mm() - kDetectable_mm)
    return with_errors(std::move(cause), given.error_mm(), "identified arm's");
  if (given.largest_deviation >= kMostSigmas && fixed.largest_deviation < kMostSigmas) {
    cause.sentence += formatted(
        " the largest deviation of a link falls from %.2g to %.2g times what arms are usually off by",
        given.largest_deviation, fixed.largest_deviation);
    return cause;
  }
  // Of a row that is missing alone: a badly built arm may be bent to fit more points, and rows in any order
  // fit most.
  const Hypothesis& first = explaining.front();
  const bool is_gap = first.mistakes.size() == 1 && first.fixed.from_row > 0;
  if (is_gap && given.share_missed() > kGrossErrors &&
      fixed.share_missed() < given.share_missed() / kBetter) {
    cause.sentence += formatted(" %.0f %% of the points fit nowhere in place of %.0f %%",
                                100 * fixed.share_missed(), 100 * given.share_missed());
    return cause;
  }
  return std::nullopt;
}

/// A mistake that hardly shows before the links are identified: a reflector near an axis does not see which
/// way its joint turns.
std::optional<ProbableCause> hidden_mistake(const RobotModel& nominal, const MeasurementData& data,
                                            int jobs) {
  const Diagnosis diagnosis(nominal, data.smr_names, data.points, kPosesToIdentify, jobs);
  const Explanation& given = diagnosis.as_given().explanation;
  if (given.error_mm() < kDetectable_mm && given.share_missed() < kGrossErrors) return std::nullopt;
  std::vector<std::vector<Mistake>> tries;
  for (const auto& mistakes :
       {sign_mistakes(nominal), zero_mistakes(nominal), row_order_mistakes(data.smr_names)})
    for (const Mistake& mistake : mistakes) tries.push_back({mistake});
  const auto explaining = diagnosis.explaining(diagnosis.looks(tries), kHides * given.coarse_mm);
  return probable_cause(explaining, diagnosis, nominal, data);
}

/// Reflectors whose names are mixed up in some poses. Judged by those poses alone: few of them would not show
/// in the error of all.
std::optional<ProbableCause> mixed_reflectors(const RobotModel& nominal, const MeasurementData& data) {
  const Relabelled renamed = relabelled(nominal, data.smr_names, data.points);
  Points before, after;
  for (std::size_t k = 0; k < data.points.size(); ++k) {
    if (data.points[k].smr == renamed.points[k].smr) continue;
    before.push_back(data.points[k]);
    after.push_back(renamed.points[k]);
  }
  if (before.empty()) return std::nullopt;

  const CalibratedCell cell = placed({.arm = nominal, .points = renamed.points, .open = {}}, data.smr_names);
  const double error_mm = median(misses(cell, before));
  ProbableCause mixed{.fixed_mm = median(misses(cell, after))};
  if (error_mm < kDeviates_mm || error_mm < kBetterOfSeveral * mixed.fixed_mm) return std::nullopt;
  mixed.sentence = "the reflectors are mixed up in " + std::to_string(renamed.rows.size()) + " of " +
                   std::to_string(pose_groups(data.points).size()) + " poses (first in row " +
                   std::to_string(renamed.rows.front()) + "): with their names exchanged";
  return with_errors(std::move(mixed), error_mm, "coarse");
}

/// Whether the links need only be off by what arms are off by to explain the points: then no mistake does it
/// better.
bool merely_deviates(const Explanation& as_given, double gross_errors) {
  return as_given.largest_deviation < kMostSigmas && as_given.share_missed() <= gross_errors &&
         as_given.error_mm() < kExplained * as_given.coarse_mm;
}

/// Whether the flange's orientation is the same at all points. Few parameters are then identifiable, and the
/// residuals of the best fits of two arms differ by chance only.
bool holds_its_flange(const RobotModel& robot, const Points& points) {
  constexpr double kHeld_rad = 0.1 * kRadPerDeg;
  const std::vector<Eigen::Isometry3d> flange = flange_poses(robot, points);
  return std::ranges::all_of(flange, [&](const Eigen::Isometry3d& X_BF) {
    return angle_between(flange.front().linear(), X_BF.linear()) < kHeld_rad;
  });
}

/// Robot file and points in metres fit each other, and no arm. Angles may be in rad besides.
std::optional<ProbableCause> all_in_metres(const RobotModel& nominal, const MeasurementData& data) {
  if (!has_no_reach(nominal)) return std::nullopt;
  ModelAndPoints fixed{.arm = nominal, .points = data.points, .open = {}};
  const UnitMistakes units = units_by_magnitude(nominal, data.points);
  if (units.measurements.empty() || units.measurements.back().key != "x, y, z") return std::nullopt;
  std::vector<Mistake> mistakes = units.robot;
  mistakes.insert(mistakes.end(), units.measurements.begin(), units.measurements.end());
  for (const Mistake& mistake : mistakes) mistake.apply_fix(fixed);
  const double left_mm =
      Diagnosis(fixed.arm, data.smr_names, fixed.points, kPoses).as_given().explanation.coarse_mm;
  if (left_mm > kMaxArmError_mm) return std::nullopt;
  std::string wrong = "the lengths of the robot file and the points are in m, not mm";
  for (const Mistake& mistake : mistakes) {
    if (mistake.key != "a" && mistake.key != "x, y, z")
      wrong += " and " + mistake.words(nominal, fixed).wrong;
  }
  return ProbableCause{
      .error_mm = left_mm,
      .fixed_mm = left_mm,
      .sentence = wrong + ": as they stand the arm reaches no farther than " + mm_text(reach_mm(nominal)),
      .mistakes = mistakes,
      .fixed_arm = fixed.arm,
      .fixed_points = fixed.points,
      .others = {}};
}

ProbableCause unexplained(const RobotModel& nominal, const Hypothesis& as_given) {
  const Explanation& given = as_given.explanation;
  const std::string where = failure_pattern(nominal, as_given.fixed.points, given.miss_mm);
  return {.error_mm = given.coarse_mm,
          .fixed_mm = given.coarse_mm,
          .sentence = "the nominal arm misses the points by " + mm_text(given.coarse_mm) +
                      " and neither one nor two of the usual mistakes explain it (" +
                      (where.empty() ? "alike everywhere" : "with the links fitted most at " + where) +
                      "): are these the measurements of this robot?"};
}

}  // namespace

std::string in_words(const ProbableCause& cause) {
  std::string words = cause.sentence;
  constexpr std::size_t kMostNamed = 4;
  const std::size_t others = cause.others.size(), named = std::min(others, kMostNamed);
  for (std::size_t k = 0; k < named; ++k)
    words += (k == 0 ? "; the data fit as well if " : ", or if ") + cause.others[k].sentence;
  if (others > named) words += ", or in " + std::to_string(others - named) + " other ways";
  return words;
}

namespace {

/// What is wrong with files in mm and deg.
std::optional<ProbableCause> wrong_structure(const RobotModel& nominal, const MeasurementData& data,
                                             int jobs) {
  if (auto mixed = mixed_reflectors(nominal, data)) return mixed;
  const Diagnosis diagnosis(nominal, data.smr_names, data.points, kPoses, jobs);
  const Explanation& given = diagnosis.as_given().explanation;
  const bool off = given.coarse_mm > kDeviates_mm && !merely_deviates(given, kGrossErrors);
  if (off) {
    const auto explaining = gross_mistakes(diagnosis, nominal, data, jobs);
    if (auto gross = probable_cause(explaining, diagnosis, nominal, data)) return gross;
  }
  const bool held = holds_its_flange(nominal, data.points);
  if (!held || given.coarse_mm > kDeviates_mm) {
    if (auto hidden = hidden_mistake(nominal, data, jobs)) return hidden;
  }
  if (given.coarse_mm <= kMaxArmError_mm || merely_deviates(given, kManyGrossErrors)) return std::nullopt;
  return unexplained(nominal, diagnosis.as_given());
}

/// The files converted from the units that their magnitudes show.
struct ConvertedFiles {
  std::vector<Mistake> units;
  ModelAndPoints fixed;
  std::string wrong;          ///< "the angles of the robot file are in rad, not deg and .."
  bool beyond_doubt = false;  ///< joints alone may be small; lengths, alphas and points are not
};

ConvertedFiles converted(const RobotModel& nominal, const MeasurementData& data) {
  UnitMistakes shown = units_by_magnitude(nominal, data.points);
  ConvertedFiles files{.units = std::move(shown.robot),
                       .fixed = {.arm = nominal, .points = data.points, .open = {}},
                       .wrong = {}};
  std::ranges::move(shown.measurements, std::back_inserter(files.units));
  for (const Mistake& unit : files.units) {
    unit.apply_fix(files.fixed);
    files.wrong += (files.wrong.empty() ? "" : " and ") + unit.words(nominal, files.fixed).wrong;
    files.beyond_doubt |= unit.key != "q1";
  }
  return files;
}

/// Part of the points' spread that base and reflectors alone leave.
double left_of_spread(const RobotModel& arm, std::span<const std::string> smr_names, const Points& points) {
  return Diagnosis(arm, smr_names, points, kPoses).as_given().explanation.coarse_mm /
         median(distances_from_middle(points));
}

/// Units, and what else is wrong once they are converted; nothing where the converted files are no better.
std::optional<ProbableCause> in_other_units(const RobotModel& nominal, const MeasurementData& data,
                                            const ConvertedFiles& files, int jobs) {
  const MeasurementData as_converted{.smr_names = data.smr_names, .points = files.fixed.points};
  auto cause = wrong_structure(files.fixed.arm, as_converted, jobs);
  if (cause && cause->mistakes.empty()) return std::nullopt;
  const auto with_units = [&](ProbableCause& each) {
    each.mistakes.insert(each.mistakes.begin(), files.units.begin(), files.units.end());
  };
  if (cause) {
    with_units(*cause);
    for (ProbableCause& other : cause->others) with_units(other);
    cause->sentence = files.wrong + " and " + cause->sentence;
    return cause;
  }
  const double left_mm =
      Diagnosis(files.fixed.arm, data.smr_names, files.fixed.points, kPoses).as_given().explanation.coarse_mm;
  if (left_mm > kMaxArmError_mm) return std::nullopt;
  const double given_mm =
      Diagnosis(nominal, data.smr_names, data.points, kPoses).as_given().explanation.coarse_mm;
  ProbableCause units{.fixed_mm = left_mm,
                      .sentence = files.wrong + ": with them converted",
                      .mistakes = files.units,
                      .fixed_arm = files.fixed.arm,
                      .fixed_points = files.fixed.points,
                      .others = {}};
  if (left_mm < given_mm / kBetter) return with_errors(std::move(units), given_mm, "coarse");
  units.error_mm = left_mm;
  units.sentence += " the nominal arm misses the points by " + mm_text(left_mm);
  return units;
}

/// Of an arm that no linear axis makes longer.
bool has_no_lengths(const RobotModel& robot) {
  return robot.X_flange.translation().isZero(0) && std::ranges::all_of(robot.joints, [](const Joint& joint) {
           return joint.type == JointType::Revolute && joint.a_mm == 0 && joint.d_mm == 0;
         });
}

}  // namespace

std::optional<ProbableCause> diagnose_files(const RobotModel& nominal, const MeasurementData& data,
                                            int jobs) {
  if (pose_groups(data.points).size() < kPosesToJudge) return std::nullopt;
  if (has_no_lengths(nominal))
    return ProbableCause{.sentence = "all lengths of the robot file are 0: enter those of the data sheet"};
  if (auto in_metres = all_in_metres(nominal, data)) return in_metres;
  const ConvertedFiles files = converted(nominal, data);
  const bool in_doubt =
      !files.units.empty() && left_of_spread(nominal, data.smr_names, data.points) > kMostLeftOfSpread;
  if (in_doubt) {
    if (auto units = in_other_units(nominal, data, files, jobs)) return units;
  }
  auto cause = wrong_structure(nominal, data, jobs);
  if (!in_doubt || !files.beyond_doubt || (cause && !cause->mistakes.empty())) return cause;
  return ProbableCause{
      .sentence =
          files.wrong +
          ", by their magnitudes, and something else is wrong too: convert the units first, then try again"};
}

}  // namespace truepose
