#include "core/calibrate/quick_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibrate/outlier_rejection.hpp"
#include "core/data/error_bounds.hpp"
#include "core/diagnosis/explanation.hpp"
#include "core/diagnosis/unit_mistakes.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/robust_fit.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kNotFar = 5;         // standard deviations of one coordinate; outliers begin at 6
constexpr double kMostTakenUp = 0.5;  // of the equations: with more, outliers hide each other
constexpr double kAlike = 1.3;        // times: what outliers that hide each other make of the scatter

bool links_merely_deviate(const Identification& id) {
  const ParameterLayout layout = ParameterLayout::of(id.fit.cell);
  const Eigen::VectorXd off = parameter_values(id.fit.cell) - parameter_values(id.result.coarse);
  for (int k = layout.link(0); k < layout.link(layout.joints); ++k) {
    if (!(std::abs(off[k]) <= kMostSigmas * usual_deviation(k - layout.link(0)))) return false;
  }
  return true;
}

/// Squared length of each point's whitened residual over the variance with which the others predict it, mm^2.
Eigen::VectorXd deleted_squares(const Identification& id, const LinearSystem& system) {
  const Eigen::MatrixXd covariance = id.uncertainty.covariance(id.problem.free, id.problem.free);
  const Eigen::MatrixXd JC = times(system.J, covariance) / std::pow(id.uncertainty.sigma0_mm, 2);
  Eigen::VectorXd squares(system.f.size() / 3);
  for (Eigen::Index i = 0; i < squares.size(); ++i) {
    const Eigen::Matrix3d leverage = JC.middleRows<3>(3 * i) * system.J.middleRows<3>(3 * i).transpose();
    const Eigen::Matrix3d W = inverse_cholesky(Eigen::Matrix3d::Identity() - leverage);
    squares[i] = (W * system.f.segment<3>(3 * i)).squaredNorm();
  }
  return squares;
}

/// Standard deviation of one coordinate of a whitened residual by the middle of them, which no few gross
/// errors move.
double middle_sigma_mm(const LinearSystem& system, double taken_up) {
  std::vector<double> lengths;
  for (Eigen::Index row = 0; row < system.f.size(); row += 3)
    lengths.push_back(system.f.segment<3>(row).norm());
  return sigma_from_median(lengths) / std::sqrt(1 - taken_up);
}

bool validation_is_near(const Identification& id, double sigma_mm) {
  const std::vector<Measurement> points = points_of(id.data, PoseSet::Validate);
  const WeightedPoints weighted(points, id.options.noise);
  const Eigen::VectorXd errors = residuals(id.fit.cell, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d error_mm = errors.segment<3>(3 * static_cast<Eigen::Index>(i));
    if (!(weighted.whitened_length(i, error_mm) <= kNotFar * sigma_mm)) return false;
  }
  return true;
}

}  // namespace

bool passes_quick_check(const Identification& id) {
  if (has_no_reach(id.nominal)) return false;
  const double taken_up = static_cast<double>(id.result.rank) / id.points.equations();
  const bool by_points_alone = id.problem.prior.weight.size() == 0;
  if (!id.result.converged || !by_points_alone || taken_up > kMostTakenUp || !links_merely_deviate(id))
    return false;
  const std::vector<double> miss_mm = misses(id.fit.cell, id.data.points);
  if (std::ranges::max(miss_mm) < kLeastError_mm) return true;
  if (!(median(miss_mm) < kDetectable_mm)) return false;
  const LinearSystem system = linearise(id.fit.cell, id.problem);
  const double middle_mm = middle_sigma_mm(system, taken_up);
  const double sigma_mm = std::min(middle_mm, id.uncertainty.sigma0_mm);
  return id.uncertainty.sigma0_mm < kAlike * middle_mm &&
         deleted_squares(id, system).maxCoeff() < std::pow(kNotFar * sigma_mm, 2) &&
         validation_is_near(id, sigma_mm);
}

}  // namespace truepose
