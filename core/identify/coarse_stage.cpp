#include <limits>

#include "core/identify/identification.hpp"
#include "core/identify/linear_start.hpp"
#include "core/identify/null_space.hpp"
#include "core/identify/particle_swarm.hpp"
#include "core/identify/robust_fit.hpp"

namespace truepose {
namespace {

std::optional<CalibrationError> not_separable(const CalibratedCell& cell,
                                              const LeastSquaresProblem& problem) {
  const Eigen::MatrixXd J = linearise(cell, problem).J;
  const std::vector<std::string> all = parameter_names(cell);
  const std::vector<std::string> names(all.begin(), all.begin() + J.cols());
  const NullSpace open = null_space(J, names, Eigen::VectorXd::Ones(J.cols()),
                                    Eigen::VectorXd::Constant(J.cols(), std::numeric_limits<double>::max()));
  if (open.rank == J.cols()) return std::nullopt;
  std::string sentences;
  for (const Combination& combination : open.unknown) {
    sentences += (sentences.empty() ? "" : "; ") + combination.sentence;
  }
  return CalibrationError{CalibrationFault::NotSeparable,
                          sentences + ": measure poses whose flange orientations differ about all axes"};
}

CalibratedCell coarse_start(const Identification& id) {
  const CalibrateOptions& options = id.options;
  const std::vector<Measurement>& points = id.points.points();
  if (options.start) return *options.start;
  if (options.method == CalibrationMethod::ParticleSwarm)
    return particle_swarm_start(id.nominal, id.data.smr_names, points);
  if (options.loss != Loss::Squared)
    return robust_start(id.nominal, id.data.smr_names, points, id.points.whitening());
  return linear_start(id.nominal, id.data.smr_names, points);
}

}  // namespace

std::optional<CalibrationError> fit_base_and_reflectors(Identification& id) {
  const CalibratedCell start = coarse_start(id);
  LeastSquaresProblem problem = id.points.problem(first_parameters(ParameterLayout::of(start).link(0)));
  if (id.options.loss != Loss::Squared) {
    // The arm held at nominal says who is far off, not by how much one of them should count.
    id.points.weigh(start, Loss::Tukey, robust_fit(start, problem).sigma_mm);
    problem.W = id.points.weighted_whitening();
  }
  FitResult fit = solve(id.options, start, problem, id.options.max_coarse_iterations);
  if (auto error = not_separable(fit.cell, problem)) return error;
  id.result.coarse = fit.cell;
  id.result.coarse_iterations = fit.iterations;
  id.result.coarse_rms_mm = fit.rms_mm;
  id.result.converged = fit.converged;
  id.fit = std::move(fit);
  return std::nullopt;
}

}  // namespace truepose
