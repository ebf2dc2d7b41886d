#include "core/change/drift_update.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/change/drift_fit.hpp"
#include "core/fit/measured_order.hpp"
#include "core/formatted.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/residual_distribution.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

/// Where most points are so far off, the tracker may have been set up again. Its old position is then of no
/// use.
constexpr double kFar_mm = 10;

double error_mm(const CalibratedCell& cell, const Measurement& point) {
  return (cell.predict(point) - point.p_WS_mm).norm();
}

bool far_off(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<double> errors_mm;
  for (const Measurement& point : points) errors_mm.push_back(error_mm(cell, point));
  return median(errors_mm) > kFar_mm;
}

/// Changes that are possible in addition to moved parameters.
struct Possible {
  bool readings = false;               ///< that are wrong
  bool set_up_anew = false;            ///< the tracker: the base scatters about a rigid fit
  bool all_zeros = false;              ///< moved by one cause, if any did, and by ways alike
  std::optional<PossibleChange> link;  ///< one parameter that changed; null: all lengths, by the same share
};

/// A fit, and the covariance of its parameters.
struct Fit : DriftFit {
  Possible possible;
  Eigen::MatrixXd covariance;
};

DriftFit start_of(const DriftReference& reference, std::span<const Measurement> points,
                  const Possible& possible) {
  DriftFit fit{.cell = reference.cell};
  for (PossibleChange& change : shown_changes(reference.cell, points)) {
    const bool is_zero = change.what.kind == ChangeKind::JointZero;
    if (possible.all_zeros && is_zero && fit.priors.back().is(ChangeKind::JointZero))
      fit.priors.back().changes.push_back(std::move(change));
    else
      fit.priors.push_back({.changes = {std::move(change)}});
  }
  fit.priors.push_back({.changes = {possible.link.value_or(growth_of(reference.cell))}});
  if (possible.readings) {
    for (PossibleChange& change : wrong_readings(points))
      fit.priors.push_back({.changes = {std::move(change)}});
  }
  if (possible.set_up_anew) {
    fit.cell = with_fitted_base(reference.cell, points);
    fit.priors.front().least = kFar_mm;
  }
  return fit;
}

/// Of the parameters: what the calibration left open, less what of it the estimate has taken in, and what the
/// points leave open of the changes.
Eigen::MatrixXd updated_covariance(const DriftReference& reference, const DriftFit& fit) {
  const ChangePosterior& p = fit.posterior;
  const Eigen::MatrixXd changes = congruence(p.D, p.H);
  if (reference.covariance.size() == 0) return changes;
  const Eigen::MatrixXd estimate = times(times(p.D, times_transposed(p.H, p.B)), fit.residuals->J);
  const Eigen::MatrixXd taken_in = times(estimate, reference.covariance);
  return reference.covariance + changes - taken_in - taken_in.transpose();
}

std::expected<Fit, std::string> fitted(const DriftReference& reference, std::span<const Measurement> points,
                                       const Possible& possible) {
  auto fit = fitted_drift(reference, points, start_of(reference, points, possible), Widths::Chosen);
  if (!fit) return std::unexpected(fit.error());
  const Eigen::MatrixXd covariance = updated_covariance(reference, *fit);
  return Fit{*std::move(fit), possible, covariance};
}

/// Logarithm of the probability of a fit, to compare it with others: every change that it assumes was
/// improbable.
double probability_of(const Fit& fit) {
  const auto happened = [](const ChangePrior& prior) { return prior.width > 0; };
  return fit.evidence - kPays * static_cast<double>(std::ranges::count_if(fit.priors, happened));
}

/// The more probable of two fits to the same points. Where the other one is the truth after all, the
/// parameters are off by what lies between the two.
Fit likelier_of(Fit fit, Fit other) {
  const double ahead = probability_of(fit) - probability_of(other);
  if (ahead < 0) return likelier_of(std::move(other), std::move(fit));
  const Eigen::VectorXd between = other.x - fit.x;
  fit.covariance +=
      (other.covariance - fit.covariance + between * between.transpose()) / (1 + std::exp(ahead));
  return fit;
}

/// Zeros that moved one by one, or all by one cause, as those of an arm that warmed up, by what is more
/// probable.
std::expected<Fit, std::string> likelier_fit(const DriftReference& reference,
                                             std::span<const Measurement> points, Possible possible) {
  auto one_by_one = fitted(reference, points, possible);
  if (!one_by_one) return one_by_one;
  possible.all_zeros = true;
  auto all = fitted(reference, points, possible);
  if (!all) return all;
  return likelier_of(*std::move(one_by_one), *std::move(all));
}

/// The most probable explanation; one without a wrong reading unless the evidence speaks against that.
std::expected<Fit, std::string> best_fit(const DriftReference& reference,
                                         std::span<const Measurement> points) {
  auto best = likelier_fit(reference, points, {});
  if (!best) return best;
  const bool far = far_off(reference.cell, points);
  for (const Possible& possible : {Possible{.set_up_anew = true}, Possible{.readings = true},
                                   Possible{.readings = true, .set_up_anew = true}}) {
    if (possible.set_up_anew && !far) continue;
    auto fit = likelier_fit(reference, points, possible);
    if (fit && fit->evidence > best->evidence + kPays) best = std::move(fit);
  }
  return best;
}

bool has_grown(const Fit& fit) {
  return std::ranges::any_of(
      fit.priors, [](const ChangePrior& prior) { return prior.is(ChangeKind::Growth) && prior.width > 0; });
}

/// The parameter of a link that, changed alone, makes the points more probable: than an arm that grew by any
/// amount, than one that did not by as much as pays for a further change, of which each is one more chance.
std::optional<Change> likelier_link(const DriftReference& reference, std::span<const Measurement> points,
                                    const Fit& best) {
  std::optional<Change> likelier;
  std::vector<PossibleChange> links = link_parameters_of(reference.cell);
  double evidence =
      best.evidence + (has_grown(best) ? 0 : kPays + std::log(static_cast<double>(links.size())));
  for (PossibleChange& link : links) {
    const Change what = link.what;
    Possible possible = best.possible;
    possible.link = std::move(link);
    const auto fit = fitted(reference, points, possible);
    if (!fit || fit->evidence <= evidence) continue;
    likelier = what;
    evidence = fit->evidence;
  }
  return likelier;
}

int degrees_left(const Fit& fit) {
  return static_cast<int>(fit.posterior.left.size() - std::llround(fit.posterior.determined()));
}

/// A point as the others and the priors predict it.
struct LeftOut {
  double error_mm = 0;
  double probability = 0;  ///< of such an error
};

/// Of all points: with S the covariance of the residuals r, by (S^-1 r)_j and (S^-1)_jj alone.
std::vector<LeftOut> left_out(const Fit& fit) {
  const Eigen::MatrixXd& W = fit.residuals->inverse;
  const Eigen::MatrixXd K = covariance_of(fit.priors, nullptr, W.rows());
  const Eigen::VectorXd weighted = transposed_times(W, fit.posterior.left);
  const Eigen::MatrixXd precision = transposed_times(W, CholeskyFactor(K).solve(W));
  std::vector<LeftOut> all;
  for (Eigen::Index row = 0; row < weighted.size(); row += 3) {
    const Eigen::Vector3d g = weighted.segment<3>(row);
    const Eigen::Vector3d error = solve_symmetric(precision.block<3, 3>(row, row), g);
    all.push_back({error.norm(), chi_square_tail(error.dot(g), 3)});
  }
  return all;
}

bool is_wrong(const DriftUpdate& update, std::size_t point) {
  const Change change{ChangeKind::Reading, static_cast<int>(point)};
  return std::ranges::count(update.wrong, change, &ChangeFound::what) > 0;
}

void tell_errors(const DriftReference& reference, std::span<const Measurement> points,
                 std::span<const LeftOut> alone, DriftUpdate& update) {
  const auto right = static_cast<double>(points.size() - update.wrong.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_wrong(update, i)) continue;
    update.before_mm += error_mm(reference.cell, points[i]) / right;
    update.after_mm += error_mm(update.cell, points[i]) / right;
    update.left_out_mm += alone[i].error_mm / right;
  }
}

std::vector<std::string> contradicted(const DriftUpdate& update, std::span<const Measurement> points,
                                      std::span<const LeftOut> alone) {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_wrong(update, i) || alone[i].probability >= kSignificance / static_cast<double>(points.size()))
      continue;
    sentences.push_back(formatted("point %d is %.2f mm from where the others put it: measure it again",
                                  points[i].row > 0 ? points[i].row : static_cast<int>(i) + 1,
                                  alone[i].error_mm));
  }
  return sentences;
}

std::vector<Measurement> right_points(const DriftUpdate& update, std::span<const Measurement> points) {
  std::vector<Measurement> right;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_wrong(update, i)) right.push_back(points[i]);
  return right;
}

bool agree(std::span<const Measurement> points, const DriftReference& reference,
           const ResidualDistribution& law) {
  const auto residuals = drift_residuals(reference, reference.cell, points);
  return residuals && law.tail(residuals->r, static_cast<int>(residuals->r.size()),
                               points_per_stop(points)) >= kSignificance;
}

/// Whether points that the update has not seen are still as far off as without it.
bool predicts_badly(const DriftUpdate& update, const DriftReference& reference) {
  return update.left_out_mm > std::max(update.before_mm / 2, kLargeFactor * reference.validation_mean_mm) ||
         !improves(update.before_mm, update.left_out_mm);
}

}  // namespace

std::expected<DriftUpdate, std::string> update_after_drift(const DriftReference& reference,
                                                           std::span<const Measurement> points) {
  const auto fit = best_fit(reference, points);
  if (!fit) return std::unexpected(fit.error());
  DriftUpdate update{.cell = fit->cell, .covariance = fit->covariance};
  for (ChangeFound& found : found_in(*fit, reference))
    (found.what.kind == ChangeKind::Reading ? update.wrong : update.moves).push_back(std::move(found));
  const std::vector<LeftOut> alone = left_out(*fit);
  tell_errors(reference, points, alone, update);
  const int degrees = degrees_left(*fit);
  const ResidualDistribution law(reference.validation_distances2);
  update.probability = law.tail(fit->posterior.left, std::max(1, degrees), points_per_stop(points));

  const bool enough_left = degrees >= static_cast<int>(points.size());
  const auto link = likelier_link(reference, points, *fit);
  update.doubts = contradicted(update, points, alone);
  update.explains = update.doubts.empty() && update.probability >= kSignificance && enough_left && !link;
  const auto doubt = [&update](bool doubted, const std::string& why) {
    if (doubted) update.doubts.push_back(why);
  };
  if (update.moves.empty()) {
    doubt(true, "nothing has moved that the points could show");
    return update;
  }
  doubt(agree(right_points(update, points), reference, law), "the points agree with the model as it is");
  doubt(
      update.probability < kSignificance,
      "moved base, reflectors and joint zeros, and thermal drift, do not explain the points: calibrate again");
  if (link)
    doubt(true, parameter_names(reference.cell)[static_cast<std::size_t>(link->index)] +
                    ", changed alone, explains the points better: calibrate again");
  doubt(!enough_left, "so much has moved that the points leave too little to check it by: measure more");
  doubt(
      predicts_badly(update, reference),
      formatted("each point, predicted by the others alone, is off by %.3f mm on average, with the old model "
                "by %.3f mm: measure more, or calibrate again",
                update.left_out_mm, update.before_mm));
  return update;
}

}  // namespace truepose
