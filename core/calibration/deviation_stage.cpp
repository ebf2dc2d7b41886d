#include "core/calibration/identification.hpp"

namespace truepose {
namespace {

/// The prior of the deviation terms, beside that of the links where one is used.
void widen_prior(Identification& id, const ParameterLayout& layout) {
  Prior prior{Eigen::VectorXd::Zero(layout.size()), Eigen::VectorXd::Zero(layout.size())};
  if (id.problem.prior.weight.size() > 0) {
    const int links = layout.link(layout.joints);
    prior.centre.head(links) = id.problem.prior.centre.head(links);
    prior.weight.head(links) = id.problem.prior.weight.head(links);
  }
  prior.weight.tail(layout.deviations).setConstant(id.uncertainty.sigma0_mm / id.result.deviation->scale);
  id.problem.prior = std::move(prior);
}

}  // namespace

void fit_deviations(Identification& id) {
  const TrustedProblem trusted = trusted_problem(id);
  id.result.deviation = choose_deviation(id.fit.cell, trusted.problem,
                                         deviation_groups(id.nominal, trusted.points, id.options.harmonics));
  if (id.result.deviation->terms.empty()) return;

  CalibratedCell start = id.fit.cell;
  start.robot.deviation = id.result.deviation->terms;
  start.robot.torque_joints = id.nominal.joints;
  const ParameterLayout layout = ParameterLayout::of(start);
  for (int t = 0; t < layout.deviations; ++t) id.problem.free.push_back(layout.deviation(t));
  widen_prior(id, layout);
  id.fit = fit_under_loss(id, start);
  assess(id);
  widen_prior(id, layout);  // with the noise that is left once the deviations are in
  id.fit = solve(id.options, id.fit.cell, id.problem, id.options.max_fine_iterations);
  assess(id);
  id.result.converged = id.result.converged && id.fit.converged;
}

}  // namespace truepose
