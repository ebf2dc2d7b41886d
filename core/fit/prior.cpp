#include "core/fit/prior.hpp"

#include "core/arm/joint_deviation.hpp"
#include "core/data/calibrated_cell.hpp"

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

}  // namespace truepose
