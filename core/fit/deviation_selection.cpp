#include "core/fit/deviation_selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/left_out_poses.hpp"
#include "core/math/parallel.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

// The layer must be so many standard errors beyond what chance gives, or one where it takes half of the
// squared error.
constexpr double kErrors = 2, kSpeaksForItself = 0.5;
// Gears of arms err by 0.05 to 0.3 mrad, which a sine and a cosine share. Wider terms fit no better, and do
// harm where nothing was measured.
constexpr double kWidest_rad = 0.2e-3;
// Of what a centre of mass off a link's origin adds to what the weights there bend. Moments are many and like
// one another in a part of the reach: wider, they take up there what is something else.
constexpr double kWidestMoment_rad = 0.1e-3;

double sum(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// The folds are a sample of differences.
bool pays(std::span<const double> before, std::span<const double> errors) {
  const double gained = standard_errors_gained(before, errors);
  return gained > kErrors || (sum(errors) < kSpeaksForItself * sum(before) && gained > 1);
}

/// The geometric cell and its problem with the terms of every group.
struct Candidates {
  CalibratedCell cell;
  LeastSquaresProblem problem;
  ScaleExpectation expected;
  std::vector<std::vector<int>> terms;  // of each group
};

Candidates candidates_of(const CalibratedCell& geometric, const LeastSquaresProblem& problem,
                         std::span<const DeviationGroup> groups, const ScaleExpectation& expected) {
  Candidates all{geometric, problem, expected, {}};
  const int first_term = ParameterLayout::of(geometric).deviation(0);
  for (const DeviationGroup& group : groups) {
    std::vector<int>& mine = all.terms.emplace_back();
    for (const DeviationTerm& term : group.terms) {
      mine.push_back(static_cast<int>(all.expected.terms.size()));
      all.problem.free.push_back(first_term + mine.back());
      all.cell.robot.deviation.push_back(term);
      all.expected.terms.push_back({static_cast<int>(group.cause), group.unit_of(term)});
    }
  }
  for (int cause = 0; cause < kDeviationCauses; ++cause)
    all.expected.deviations.push_back(usual_width(static_cast<DeviationCause>(cause)));
  const auto size = static_cast<Eigen::Index>(ParameterLayout::of(all.cell).size());
  for (Eigen::VectorXd* v : {&all.problem.prior.centre, &all.problem.prior.weight}) {
    if (v->size() > 0) v->conservativeResizeLike(Eigen::VectorXd::Zero(size));
  }
  return all;
}

bool errs_as_gears_do(DeviationCause cause) {
  return cause != DeviationCause::Pitch && cause != DeviationCause::Bends && cause != DeviationCause::Twists;
}

double widest_rad(DeviationCause cause) {
  return cause == DeviationCause::MassMoments ? kWidestMoment_rad : kWidest_rad;
}

/// The most likely scale, no term of a revolute joint wider than gears err.
VarianceComponents bounded_scale(const Candidates& all, std::span<const DeviationGroup> groups) {
  VarianceComponents likely = most_likely_components(all.cell, all.problem, all.expected);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!errs_as_gears_do(groups[g].cause)) continue;
    for (const int term : all.terms[g]) {
      double& width = likely.term_widths[static_cast<std::size_t>(term)];
      width = std::min(width, widest_rad(groups[g].cause) * groups[g].unit);
    }
  }
  return likely;
}

/// The terms of every group but `without` (-1: of every group).
std::vector<int> terms_but(const Candidates& all, int without) {
  std::vector<int> terms;
  for (int g = 0; g < static_cast<int>(all.terms.size()); ++g) {
    const std::vector<int>& mine = all.terms[static_cast<std::size_t>(g)];
    if (g != without) terms.insert(terms.end(), mine.begin(), mine.end());
  }
  return terms;
}

std::vector<double> left_out_errors(const LeftOutPoses& poses, const std::vector<int>& terms,
                                    const VarianceComponents& likely) {
  Eigen::VectorXd ridge(static_cast<Eigen::Index>(terms.size()));
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const double width = likely.term_widths[static_cast<std::size_t>(terms[k])];
    ridge[static_cast<Eigen::Index>(k)] = std::pow(likely.sigma_mm / width, 2);
  }
  return poses.squared_errors(terms, ridge);
}

}  // namespace

DeviationChoice choose_deviation(const CalibratedCell& geometric, const LeastSquaresProblem& problem,
                                 std::span<const DeviationGroup> groups, const ScaleExpectation& expected,
                                 int jobs) {
  const Candidates all = candidates_of(geometric, problem, groups, expected);
  std::optional<LeftOutPoses> poses;
  VarianceComponents likely;
  parallel_for(2, jobs, [&](int i) {
    if (i == 0) poses.emplace(all.cell, all.problem, static_cast<Eigen::Index>(problem.free.size()));
    if (i == 1 && !groups.empty()) likely = bounded_scale(all, groups);
  });
  const auto rms = [&](const std::vector<double>& errors) {
    return std::sqrt(sum(errors) / static_cast<double>(problem.points.size()));
  };
  const std::vector<double> without = poses->squared_errors({}, {});
  DeviationChoice choice{.geometric_rms_mm = rms(without), .rms_mm = rms(without)};
  if (groups.empty()) return choice;

  const std::vector<double> with = left_out_errors(*poses, terms_but(all, -1), likely);
  const bool chosen = pays(without, with);
  choice.gains.resize(groups.size());
  parallel_for(static_cast<int>(groups.size()), jobs, [&](int g) {
    const auto group = static_cast<std::size_t>(g);
    const std::vector<double> but_one = left_out_errors(*poses, terms_but(all, g), likely);
    choice.gains[group] = {groups[group].name, chosen, rms(but_one)};
  });
  if (!chosen) return choice;
  choice.terms = all.cell.robot.deviation;
  choice.likely = likely;
  choice.scale = std::ranges::max(likely.term_widths);
  choice.rms_mm = rms(with);
  return choice;
}

}  // namespace truepose
