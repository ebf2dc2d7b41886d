#include "core/identify/prior.hpp"

#include <cmath>
#include <limits>

#include "core/arm/joint_deviation.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

Prior prior_of(const CalibratedCell& nominal, const PriorScale& scale, double sigma_mm) {
  const ParameterLayout layout = ParameterLayout::of(nominal);
  Prior prior{.centre = parameter_values(nominal), .weight = Eigen::VectorXd::Zero(layout.size())};
  const int coordinates = ParameterLayout::kReflector * layout.reflectors;
  prior.centre.segment(layout.reflector(0), coordinates).setZero();
  prior.weight.segment(layout.reflector(0), coordinates).setConstant(sigma_mm / scale.reflector_mm);
  const double length = sigma_mm / scale.length_mm, angle = sigma_mm / scale.angle_rad;
  for (int i = 0; i < layout.joints; ++i) {
    prior.weight.segment<ParameterLayout::kLink>(layout.link(i)) << length, angle, length, angle, angle;
  }
  prior.centre.tail(layout.deviations).setZero();
  for (int t = 0; t < layout.deviations; ++t) {
    const bool along = moves_along(nominal.robot, nominal.robot.deviation[static_cast<std::size_t>(t)]);
    prior.weight[layout.deviation(t)] = along ? length : sigma_mm / scale.deviation;
  }
  return prior;
}

Prior ridge_prior(const CalibratedCell& cell, const LeastSquaresProblem& problem, const PriorScale& scale) {
  LeastSquaresProblem unshrunk = problem;
  unshrunk.prior = {};
  const LinearSystem system = linearise(cell, unshrunk);
  const Prior unit = prior_of(cell, scale, 1.0);
  Eigen::VectorXd weight(static_cast<Eigen::Index>(problem.free.size()));
  for (Eigen::Index k = 0; k < weight.size(); ++k) {
    weight[k] = unit.weight[problem.free[static_cast<std::size_t>(k)]];
  }
  const Eigen::MatrixXd normal = gram(system.J);
  const Eigen::VectorXd g = transposed_times(system.J, system.f);
  const auto equations = static_cast<double>(system.f.size() - system.mountings);

  double best_score = std::numeric_limits<double>::infinity(), best_sigma = 0;
  for (double sigma = 1e-3; sigma < 1e2; sigma *= std::sqrt(10.0)) {
    Eigen::MatrixXd shrunk = normal;
    shrunk.diagonal() += (sigma * weight).cwiseAbs2();
    const double determined = solve_symmetric(shrunk, normal).trace();
    const double square = (system.f - times(system.J, solve_symmetric(shrunk, g))).squaredNorm();
    const double freedom = 1 - determined / equations;
    const double score = square / (freedom * freedom);
    if (score >= best_score) continue;
    best_score = score;
    best_sigma = sigma;
  }
  return prior_of(cell, scale, best_sigma);
}

}  // namespace truepose
