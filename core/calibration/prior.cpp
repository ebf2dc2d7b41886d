#include "core/calibration/prior.hpp"

#include "core/calibration/parameters.hpp"

namespace truepose {

Prior prior_of(const CalibratedCell& nominal, const PriorScale& scale, double sigma_mm) {
  const ParameterLayout layout = ParameterLayout::of(nominal);
  Prior prior{.centre = parameter_values(nominal), .weight = Eigen::VectorXd::Zero(layout.size())};
  const double length = sigma_mm / scale.length_mm, angle = sigma_mm / scale.angle_rad;
  for (int i = 0; i < layout.joints; ++i) {
    prior.weight.segment<ParameterLayout::kLink>(layout.link(i)) << length, angle, length, angle, angle;
  }
  prior.centre.tail(layout.deviations).setZero();
  prior.weight.tail(layout.deviations).setConstant(sigma_mm / scale.deviation);
  return prior;
}

}  // namespace truepose
