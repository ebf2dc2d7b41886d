#include "core/identify/deviation_selection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kFolds = 10;
constexpr std::array kScales{3e-3, 1e-3, 0.3e-3, 0.1e-3, 0.03e-3};
constexpr double kLeastGroupGain = 0.01;  // a group must take this part of the squared error
// The groups are the best of many, so all together must be further beyond chance than one alone, or take half
// of the squared error.
constexpr double kErrorsPerGroup = 1, kErrorsTogether = 4, kSpeaksForItself = 0.5;

std::string joint_name(int i) { return "joint" + std::to_string(i + 1); }

bool approach_varies(std::span<const Measurement> points, std::size_t joint) {
  bool up = false, down = false;
  for (const Measurement& point : points) {
    if (joint >= point.direction.size()) continue;
    up |= point.direction[joint] > 0;
    down |= point.direction[joint] < 0;
  }
  return up && down;
}

/// Unit weights at the origins outboard of joint i whose torque is neither nothing nor that of one before.
std::vector<DeviationTerm> weight_terms(const RobotModel& robot, std::span<const Measurement> points, int i) {
  std::vector<DeviationTerm> kept;
  std::vector<Eigen::VectorXd> columns;
  for (int frame = i + 2; frame <= robot.joint_count() + 1; ++frame) {
    RobotModel one = robot;
    one.deviation = {{i, DeviationBasis::Weight, frame, 0}};
    Eigen::VectorXd column(static_cast<Eigen::Index>(points.size()));
    for (std::size_t n = 0; n < points.size(); ++n) {
      deviation_basis(one, points[n].q, {}, std::span(&column[static_cast<Eigen::Index>(n)], 1));
    }
    const double norm = column.norm();
    const bool varies = (column.array() - column.mean()).matrix().norm() > 1e-9 * (1 + norm);
    const bool known = std::ranges::any_of(
        columns, [&](const Eigen::VectorXd& other) { return (other - column).norm() < 1e-9 * (1 + norm); });
    if (!varies || known) continue;
    columns.push_back(column);
    kept.push_back(one.deviation.front());
  }
  return kept;
}

/// One fold, geometry eliminated: what the other folds say of the coefficients, and how wrong they are here.
struct Fold {
  Eigen::MatrixXd normal;  // of the deviation columns, from the other folds
  Eigen::VectorXd right;
  Eigen::MatrixXd here_normal;  // of the points left out
  Eigen::VectorXd here_right;
  double here_square = 0;  // squared error left out, without deviations
};

struct Normal {
  Eigen::MatrixXd JtJ;
  Eigen::VectorXd Jtf;
  double ff = 0;
};

Normal normal_of(const Eigen::MatrixXd& J, const Eigen::VectorXd& f) {
  return {gram(J), transposed_times(J, f), f.squaredNorm()};
}

/// The geometric parameters come first, `geometry` of them.
Fold eliminated(const Normal& all, const Normal& here, Eigen::Index geometry) {
  const Eigen::Index terms = all.Jtf.size() - geometry;
  const Eigen::MatrixXd rest = all.JtJ - here.JtJ;
  const Eigen::VectorXd rest_right = all.Jtf - here.Jtf;
  Eigen::MatrixXd gg = rest.topLeftCorner(geometry, geometry);
  gg.diagonal() *= 1 + 1e-12;
  // x_g = -C_right - C x_d with all right-hand sides of the sign of f = model - measured.
  Eigen::MatrixXd right(geometry, terms + 1);
  right << rest.topRightCorner(geometry, terms), rest_right.head(geometry);
  const Eigen::MatrixXd solved = solve_symmetric(gg, right);
  const Eigen::MatrixXd C = solved.leftCols(terms);
  const Eigen::VectorXd c = solved.col(terms);

  Fold fold;
  fold.normal = rest.bottomRightCorner(terms, terms) - times(rest.bottomLeftCorner(terms, geometry), C);
  fold.right = rest_right.tail(terms) - transposed_times(C, rest_right.head(geometry));
  // Here: f + J_g x_g + J_d x_d = (f - J_g c) + (J_d - J_g C) x_d.
  const auto gg_here = here.JtJ.topLeftCorner(geometry, geometry);
  const auto gd_here = here.JtJ.topRightCorner(geometry, terms);
  const Eigen::VectorXd gg_c = times(gg_here, c), without_c = here.Jtf.head(geometry) - gg_c;
  fold.here_square = here.ff - 2 * c.dot(here.Jtf.head(geometry)) + c.dot(gg_c);
  fold.here_right = here.Jtf.tail(terms) - transposed_times(C, without_c) - transposed_times(gd_here, c);
  const Eigen::MatrixXd CtD = transposed_times(C, gd_here), CtGC = transposed_times(C, times(gg_here, C));
  fold.here_normal = here.JtJ.bottomRightCorner(terms, terms) - CtD - CtD.transpose() + CtGC;
  return fold;
}

/// Squared error of each fold, left out, with the columns `active` shrunk by `ridge`.
std::vector<double> left_out_errors(std::span<const Fold> folds, const std::vector<int>& active,
                                    double ridge) {
  std::vector<double> errors;
  for (const Fold& fold : folds) {
    if (active.empty()) {
      errors.push_back(fold.here_square);
      continue;
    }
    Eigen::MatrixXd normal = fold.normal(active, active);
    normal.diagonal().array() += ridge;
    const Eigen::VectorXd x = -solve_symmetric(normal, Eigen::VectorXd(fold.right(active)));
    const Eigen::VectorXd here_right = fold.here_right(active);
    const Eigen::MatrixXd here_normal = fold.here_normal(active, active);
    errors.push_back(fold.here_square + 2 * x.dot(here_right) + times(here_normal, x).col(0).dot(x));
  }
  return errors;
}

double sum(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Whether `errors` is lower than `before` by so many standard errors: the folds are a sample of differences.
bool beyond_chance(std::span<const double> before, std::span<const double> errors, double standard_errors) {
  const auto n = static_cast<double>(before.size());
  const double mean = (sum(before) - sum(errors)) / n;
  double squares = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    const double d = before[k] - errors[k] - mean;
    squares += d * d;
  }
  const double standard_error = std::sqrt(squares / (n - 1) / n);
  return mean > standard_errors * standard_error;
}

bool one_pays(std::span<const double> before, std::span<const double> errors) {
  return sum(before) - sum(errors) > kLeastGroupGain * sum(before) &&
         beyond_chance(before, errors, kErrorsPerGroup);
}

bool all_pay(std::span<const double> before, std::span<const double> errors) {
  return beyond_chance(before, errors, kErrorsTogether) ||
         (sum(errors) < kSpeaksForItself * sum(before) && beyond_chance(before, errors, kErrorsPerGroup));
}

struct Selection {
  std::vector<bool> chosen;
  std::vector<double> errors;
};

class Selector {
 public:
  Selector(std::vector<Fold> folds, std::vector<std::vector<int>> columns, double equations)
      : folds_{std::move(folds)}, columns_{std::move(columns)}, equations_{equations} {}

  /// Adds the best group while that pays, then takes away what others have made needless.
  Selection select(double scale) const {
    Selection none{std::vector<bool>(columns_.size(), false), {}};
    none.errors = errors_of(none.chosen, scale, 0);
    Selection best = none;
    while (const auto next = best_change(best, scale, false)) best = *next;
    while (const auto next = best_change(best, scale, true)) best = *next;
    if (all_pay(none.errors, best.errors)) return best;
    return none;
  }

  /// @param square  squared error from which the noise, and with it the strength of the prior, is judged
  std::vector<double> errors_of(const std::vector<bool>& chosen, double scale, double square) const {
    std::vector<int> active;
    for (std::size_t g = 0; g < columns_.size(); ++g) {
      if (chosen[g]) active.insert(active.end(), columns_[g].begin(), columns_[g].end());
    }
    return left_out_errors(folds_, active, square / equations_ / (scale * scale));
  }

  double sum_of_none() const { return sum(left_out_errors(folds_, {}, 0)); }

 private:
  std::optional<Selection> best_change(const Selection& from, double scale, bool remove) const {
    std::optional<Selection> best;
    const double square = sum(from.errors);
    for (std::size_t g = 0; g < columns_.size(); ++g) {
      if (from.chosen[g] != remove) continue;
      Selection next = from;
      next.chosen[g] = !remove;
      next.errors = errors_of(next.chosen, scale, square);
      const bool pays = remove ? sum(next.errors) <= square : one_pays(from.errors, next.errors);
      if (pays && (!best || sum(next.errors) < sum(best->errors))) best = std::move(next);
    }
    return best;
  }

  std::vector<Fold> folds_;
  std::vector<std::vector<int>> columns_;
  double equations_;
};

std::vector<Fold> folds_of(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                           Eigen::Index geometry) {
  const LinearSystem system = linearise(cell, problem);
  const Eigen::Index rows = 3 * static_cast<Eigen::Index>(problem.points.size());
  const std::vector<int> pose = pose_numbers(problem.points);
  const int count = std::min(kFolds, count_poses(problem.points));

  std::vector<Normal> parts;
  for (int k = 0; k < count; ++k) {
    std::vector<Eigen::Index> mine;
    for (std::size_t i = 0; i < pose.size(); ++i) {
      if (pose[i] % count != k) continue;
      for (Eigen::Index c = 0; c < 3; ++c) mine.push_back(3 * static_cast<Eigen::Index>(i) + c);
    }
    parts.push_back(normal_of(system.J(mine, Eigen::all), system.f(mine)));
  }
  Normal all = normal_of(system.J, system.f);  // the prior's rows are never left out
  all.ff = system.f.head(rows).squaredNorm();
  std::vector<Fold> folds;
  for (const Normal& part : parts) folds.push_back(eliminated(all, part, geometry));
  return folds;
}

}  // namespace

std::vector<DeviationGroup> deviation_groups(const RobotModel& robot, std::span<const Measurement> points,
                                             std::span<const int> harmonics) {
  std::vector<DeviationGroup> groups;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (robot.joints[joint].type == JointType::Revolute) {
      for (const int order : harmonics) {
        groups.push_back({joint_name(i) + ".harmonic" + std::to_string(order),
                          {{i, DeviationBasis::Sine, order, 0}, {i, DeviationBasis::Cosine, order, 0}}});
      }
    } else {
      groups.push_back({joint_name(i) + ".scale", {{i, DeviationBasis::Scale, 1, 0}}});
    }
    std::vector<DeviationTerm> gravity = robot.masses.empty()
                                             ? weight_terms(robot, points, i)
                                             : std::vector<DeviationTerm>{{i, DeviationBasis::Gravity, 1, 0}};
    if (!gravity.empty()) groups.push_back({joint_name(i) + ".gravity", std::move(gravity)});
    if (approach_varies(points, joint)) {
      groups.push_back({joint_name(i) + ".approach", {{i, DeviationBasis::Approach, 1, 0}}});
    }
  }
  return groups;
}

DeviationChoice choose_deviation(const CalibratedCell& geometric, const LeastSquaresProblem& problem,
                                 std::span<const DeviationGroup> groups) {
  CalibratedCell cell = geometric;
  LeastSquaresProblem candidates = problem;
  const auto geometry = static_cast<Eigen::Index>(problem.free.size());
  const int first_term = ParameterLayout::of(geometric).size();
  std::vector<std::vector<int>> columns;
  for (const DeviationGroup& group : groups) {
    std::vector<int>& mine = columns.emplace_back();
    for (const DeviationTerm& term : group.terms) {
      mine.push_back(static_cast<int>(cell.robot.deviation.size()));
      candidates.free.push_back(first_term + mine.back());
      cell.robot.deviation.push_back(term);
    }
  }
  const auto terms = static_cast<Eigen::Index>(cell.robot.deviation.size());
  for (Eigen::VectorXd* v : {&candidates.prior.centre, &candidates.prior.weight}) {
    if (v->size() == 0) continue;
    v->conservativeResize(v->size() + terms);
    v->tail(terms).setZero();
  }

  const double equations = 3.0 * static_cast<double>(problem.points.size());
  const Selector selector(folds_of(cell, candidates, geometry), std::move(columns), equations);
  const auto rms = [&](double square) { return std::sqrt(3 * square / equations); };

  DeviationChoice choice;
  Selection best;
  for (const double scale : kScales) {
    Selection selection = selector.select(scale);
    if (!best.errors.empty() && sum(selection.errors) >= sum(best.errors)) continue;
    best = std::move(selection);
    choice.scale = scale;
  }
  choice.geometric_rms_mm = rms(selector.sum_of_none());
  choice.rms_mm = rms(sum(best.errors));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    std::vector<bool> other = best.chosen;
    other[g] = !other[g];
    choice.gains.push_back({groups[g].name, best.chosen[g],
                            rms(sum(selector.errors_of(other, choice.scale, sum(best.errors))))});
    if (!best.chosen[g]) continue;
    choice.terms.insert(choice.terms.end(), groups[g].terms.begin(), groups[g].terms.end());
  }
  return choice;
}

}  // namespace truepose
