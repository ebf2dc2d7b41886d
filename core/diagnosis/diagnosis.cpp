#include "core/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/fit/robust_fit.hpp"
#include "core/math/parallel.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kShortlist = 120;  // hypotheses fitted to the end
constexpr double kNegligible_mm = 1;     // what bearings, gears and bending leave of an arm that is right
constexpr double kMostMissed = 0.15;     // part of the points: more than are grossly wrong, by chance too
constexpr double kFinest_mm = 0.05;      // standard deviation that no difference is judged by
// Of squared misses and of squared deviations, in their standard deviations: how many times more and how much
// more is worse. Right arms differ by less than half of it.
constexpr double kWorse = 1.7, kWorseBy = 20;
constexpr double kAlikeTimes = 1.5, kAlikeBy = 12;
constexpr double kHardlyMore = 4;           // of both: the more usual mistake goes first
constexpr std::size_t kRowsInOrder = 2000;  // tell the order of all
constexpr double kNoChange = 1e-6;  // of an error: what base and reflectors take up changes it by no more
// Of the spread of the points: what base and reflectors alone leave of a right arm, with links off by 15
// mrad.
constexpr double kMostOfSpread = 0.1;
constexpr double kMostDeviation = 2;  // mean square, in what arms are usually off by

using Points = std::vector<Measurement>;

/// Coordinates of no arm, many times farther from the middle than half of the points are.
std::vector<bool> strays(const Points& points) {
  constexpr double kStray = 20;
  const std::vector<double> distances = distances_from_middle(points);
  const double most_mm = kStray * median(distances);
  std::vector<bool> strays;
  for (const double distance : distances) strays.push_back(distance > most_mm);
  return strays;
}

double share_of_strays(const Points& points) {
  const std::vector<bool> stray = strays(points);
  return static_cast<double>(std::ranges::count(stray, true)) / static_cast<double>(points.size());
}

/// Without strays, unless there are many more than there were: what a mistake is said to have moved where no
/// arm reaches stays, and speaks against it. A sample may have some more by chance.
Points without_strays(const Points& points, double share_as_given) {
  const std::vector<bool> stray = strays(points);
  const double most = 2 * share_as_given * static_cast<double>(points.size()) + 1;
  if (static_cast<double>(std::ranges::count(stray, true)) > most) return points;
  Points kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!stray[k]) kept.push_back(points[k]);
  }
  return kept;
}

/// Mean distance of the points from their middle.
double spread_mm(const Points& points) {
  Eigen::Vector3d middle{0, 0, 0};
  for (const Measurement& point : points) middle += point.p_WS_mm / static_cast<double>(points.size());
  double sum = 0;
  for (const Measurement& point : points) sum += (point.p_WS_mm - middle).norm();
  return sum / static_cast<double>(points.size());
}

/// All points of at most so many poses, spread evenly over the data.
Points sampled(const Points& points, std::size_t most_poses) {
  const auto groups = pose_groups(points);
  const std::size_t count = std::min(groups.size(), most_poses);
  Points sample;
  for (std::size_t k = 0; k < count; ++k) {
    for (const std::size_t i : groups[k * groups.size() / count]) sample.push_back(points[i]);
  }
  return sample;
}

/// What a fit needs of the points.
Points bare(std::span<const Measurement> rows) {
  Points points;
  for (const Measurement& row : rows)
    points.push_back({.q = row.q, .p_WS_mm = row.p_WS_mm, .smr = row.smr, .row = row.row});
  return points;
}

/// An entry of a link by its place among the parameters.
double Joint::*entry_at(int parameter) {
  constexpr std::array kEntries{&Joint::a_mm, &Joint::alpha_rad, &Joint::d_mm, &Joint::theta_rad,
                                &Joint::beta_rad};
  return kEntries[static_cast<std::size_t>(parameter % ParameterLayout::kLink)];
}

std::size_t joint_of(int parameter) { return static_cast<std::size_t>(parameter / ParameterLayout::kLink); }

/// What was open, as it was fitted.
void settle(ModelAndPoints& fixed, const CalibratedCell& fitted) {
  for (const int parameter : fixed.open) {
    const std::size_t i = joint_of(parameter);
    fixed.arm.joints[i].*entry_at(parameter) = fitted.robot.joints[i].*entry_at(parameter);
  }
}

/// Whether what was open is off by more than an arm that merely deviates.
bool exceeds_usual_deviation(const ModelAndPoints& fixed) {
  for (std::size_t k = 0; k < fixed.open.size(); ++k) {
    const int parameter = fixed.open[k];
    const auto entry = entry_at(parameter);
    const double off = fixed.arm.joints[joint_of(parameter)].*entry - fixed.before[k];
    const bool angle = entry != &Joint::a_mm && entry != &Joint::d_mm;
    if (std::abs(angle ? std::remainder(off, 2 * std::numbers::pi) : off) <=
        kMostSigmas * usual_deviation(parameter))
      return false;
  }
  return true;
}

/// The arm of `to` with links that deviate as those of `fitted` do from `from`.
RobotModel deviating_alike(RobotModel to, const RobotModel& from, const RobotModel& fitted) {
  for (int parameter = 0; parameter < ParameterLayout::kLink * to.joint_count(); ++parameter) {
    const std::size_t i = joint_of(parameter);
    const auto entry = entry_at(parameter);
    to.joints[i].*entry += fitted.joints[i].*entry - from.joints[i].*entry;
  }
  return to;
}

std::size_t parts(const Hypothesis& hypothesis) { return hypothesis.mistakes.size(); }
std::size_t open_parts(const Hypothesis& hypothesis) { return hypothesis.fixed.open.size(); }

/// Whether `other` says what a value is that `open` only found.
bool says(const Hypothesis& other, const Hypothesis& open) {
  return open_parts(other) < open_parts(open) &&
         std::ranges::all_of(open.mistakes, [&](const Mistake& mistake) {
           return std::ranges::any_of(other.mistakes, [&](const Mistake& said) {
             return said.file == mistake.file && said.joint == mistake.joint && said.key == mistake.key;
           });
         });
}

/// Of those with the fewest mistakes the ones that leave no value open that another says.
void keep_simplest(std::vector<Hypothesis>& hypotheses) {
  const std::size_t least = parts(*std::ranges::min_element(hypotheses, {}, parts));
  std::erase_if(hypotheses, [&](const Hypothesis& each) { return parts(each) > least; });
  const std::vector<Hypothesis> all = hypotheses;
  std::erase_if(hypotheses, [&](const Hypothesis& each) {
    return std::ranges::any_of(all, [&](const Hypothesis& other) { return says(other, each); });
  });
}

/// Whether two hypotheses are the same mistakes with what was open found at nearly the same values.
bool is_same(const Hypothesis& a, const Hypothesis& b) {
  if (a.fixed.open.empty() || a.fixed.open != b.fixed.open || parts(a) != parts(b)) return false;
  for (std::size_t k = 0; k < parts(a); ++k) {
    if (a.mistakes[k].joint != b.mistakes[k].joint || a.mistakes[k].key != b.mistakes[k].key) return false;
  }
  return std::ranges::all_of(a.fixed.open, [&](int parameter) {
    const auto entry = entry_at(parameter);
    const double off =
        a.fixed.arm.joints[joint_of(parameter)].*entry - b.fixed.arm.joints[joint_of(parameter)].*entry;
    const double turned = entry == &Joint::theta_rad ? std::remainder(off, 2 * std::numbers::pi) : off;
    return std::abs(turned) < kMostSigmas * usual_deviation(parameter);
  });
}

/// The first of those that say the same, as an open zero found from several starts.
void keep_different(std::vector<Hypothesis>& hypotheses) {
  std::vector<Hypothesis> kept;
  for (const Hypothesis& each : hypotheses) {
    const auto same = [&](const Hypothesis& other) { return is_same(each, other); };
    if (std::ranges::none_of(kept, same)) kept.push_back(each);
  }
  hypotheses = std::move(kept);
}

bool has_negligible_error(const Explanation& explanation) {
  return explanation.error_mm() <= kNegligible_mm && explanation.share_missed() <= kMostMissed;
}

}  // namespace

std::string Hypothesis::sentence(const RobotModel& given) const {
  std::string wrong, remedy;
  for (const Mistake& mistake : mistakes) {
    const MistakeWords words = mistake.words(given, fixed);
    wrong += (wrong.empty() ? "" : " and ") + words.wrong;
    if (remedy != words.remedy) remedy += (remedy.empty() ? "" : " and ") + words.remedy;
  }
  return wrong + ": with " + remedy;
}

Diagnosis::Diagnosis(const RobotModel& arm, std::span<const std::string> smr_names,
                     std::span<const Measurement> rows, std::size_t poses, int jobs)
    : arm_{arm},
      names_{smr_names},
      rows_{bare(rows)},
      poses_{poses},
      jobs_{jobs},
      strays_{share_of_strays(rows_)} {
  as_given_.fixed = {.arm = arm, .points = without_strays(sampled(rows_, poses), strays_), .open = {}};
  rough_mm_ = rough_error(as_given_.fixed, names_);
  as_given_.explanation = explanation(as_given_.fixed, placed(as_given_.fixed, names_));
}

ModelAndPoints Diagnosis::with_fixes(const std::vector<Mistake>& mistakes) const {
  const bool in_order = std::ranges::any_of(mistakes, &Mistake::needs_all_rows);
  const std::span<const Measurement> rows{rows_};
  const auto first = rows.first(std::min(rows.size(), kRowsInOrder));
  ModelAndPoints given{.arm = arm_,
                       .points = in_order ? Points{first.begin(), first.end()} : as_given_.fixed.points,
                       .open = {}};
  for (const Mistake& mistake : mistakes) mistake.apply_fix(given);
  if (in_order) given.points = without_strays(sampled(given.points, poses_), strays_);
  return given;
}

/// Whether it leaves next to no error of all rows too; that is then its explanation.
bool Diagnosis::explains_all_rows(Hypothesis& hypothesis) const {
  ModelAndPoints all{.arm = arm_, .points = rows_, .open = {}};
  for (const Mistake& mistake : hypothesis.mistakes) mistake.apply_fix(all);
  all.points = without_strays(all.points, strays_);
  all.arm = hypothesis.fixed.arm;
  all.open.clear();
  all.before.clear();
  hypothesis.explanation = explanation(all, placed(all, names_));
  return has_negligible_error(hypothesis.explanation);
}

bool Diagnosis::is_better(const Hypothesis& best, double sigma_mm) const {
  const auto is_worse = [&](const Explanation& given) {
    return given.misfit(sigma_mm) > kWorse * best.explanation.misfit(sigma_mm) + kWorseBy ||
           given.deviation > best.explanation.deviation + kWorseBy;
  };
  CalibratedCell at_base = best.explanation.cell;
  at_base.robot = arm_;
  CalibratedCell with_links = as_given_.explanation.cell;
  with_links.robot = deviating_alike(arm_, best.fixed.arm, best.explanation.cell.robot);
  return is_worse(as_given_.explanation) && is_worse(explanation(as_given_.fixed, at_base)) &&
         is_worse(explanation(as_given_.fixed, with_links));
}

std::vector<Look> Diagnosis::looks(const std::vector<std::vector<Mistake>>& tries) const {
  std::vector<Look> looks(tries.size());
  parallel_for(static_cast<int>(tries.size()), jobs_, [&](int index) {
    const auto k = static_cast<std::size_t>(index);
    const ModelAndPoints fixed = with_fixes(tries[k]);
    const double rough_mm = rough_error(fixed, names_);
    looks[k] = {.mistakes = tries[k],
                .rough_mm = rough_mm,
                .of_spread = rough_mm / spread_mm(fixed.points),
                .changes = std::abs(rough_mm - rough_mm_) >= kNoChange * rough_mm_};
  });
  return looks;
}

std::vector<Hypothesis> Diagnosis::shortlist(const std::vector<Look>& looks, double most_rough_mm) const {
  std::vector<Look> followed;
  std::ranges::copy_if(looks, std::back_inserter(followed), [&](const Look& look) {
    return look.changes && look.of_spread <= kMostOfSpread && look.rough_mm <= most_rough_mm;
  });
  if (followed.size() > kShortlist) {
    std::vector<double> sorted;
    for (const Look& look : followed) sorted.push_back(look.rough_mm);
    std::ranges::nth_element(sorted, sorted.begin() + kShortlist - 1);
    std::erase_if(followed, [&](const Look& look) { return look.rough_mm > sorted[kShortlist - 1]; });
  }
  std::vector<Hypothesis> hypotheses;
  for (Look& look : followed) hypotheses.push_back({std::move(look.mistakes), {}, {}});
  parallel_for(static_cast<int>(hypotheses.size()), jobs_, [&](int index) {
    Hypothesis& next = hypotheses[static_cast<std::size_t>(index)];
    next.fixed = with_fixes(next.mistakes);
    next.explanation = explanation(next.fixed, placed(next.fixed, names_));
    settle(next.fixed, next.explanation.cell);
  });
  std::erase_if(hypotheses, [](const Hypothesis& each) { return !exceeds_usual_deviation(each.fixed); });
  return hypotheses;
}

std::vector<Hypothesis> Diagnosis::explaining(const std::vector<Look>& looks, double most_rough_mm) const {
  std::vector<Hypothesis> hypotheses = shortlist(looks, most_rough_mm);
  if (hypotheses.empty()) return {};
  double least_mm = std::numeric_limits<double>::infinity();
  for (Hypothesis& each : hypotheses) {
    least_mm = std::min(least_mm, sigma_from_median(each.explanation.miss_mm));
  }
  const double sigma_mm = std::max(kFinest_mm, least_mm);
  const auto cost = [&](const Hypothesis& each) {
    return each.explanation.misfit(sigma_mm) + each.explanation.deviation;
  };
  const Hypothesis best = *std::ranges::min_element(hypotheses, {}, cost);
  const double links = static_cast<double>(ParameterLayout::kLink * arm_.joints.size());
  if (!has_negligible_error(best.explanation) || best.explanation.deviation > kMostDeviation * links ||
      !is_better(best, sigma_mm))
    return {};
  std::erase_if(hypotheses, [&](const Hypothesis& each) {
    return each.explanation.misfit(sigma_mm) > kAlikeTimes * best.explanation.misfit(sigma_mm) + kAlikeBy ||
           each.explanation.deviation > best.explanation.deviation + kAlikeBy;
  });
  keep_simplest(hypotheses);
  std::ranges::stable_sort(hypotheses, {},
                           [&](const Hypothesis& each) { return cost(each) > cost(best) + kHardlyMore; });
  keep_different(hypotheses);
  if (!explains_all_rows(hypotheses.front())) return {};
  return hypotheses;
}

}  // namespace truepose
