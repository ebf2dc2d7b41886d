#include "core/planning/design_problem.hpp"

#include "core/calibration/measurement_model.hpp"
#include "core/calibration/parameters.hpp"
#include "core/evaluation/cramer_rao.hpp"
#include "core/linear_algebra/decompositions.hpp"
#include "core/linear_algebra/products.hpp"

namespace truepose {
namespace {

using PoseRows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using kernels::kMostLanes;

Eigen::VectorXd scales(const CalibratedCell& cell, const DesignPrior& prior) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(layout.size());
  scale.head<3>().setConstant(prior.base_mm);
  scale.segment<3>(3).setConstant(prior.base_rad);
  scale.segment(ParameterLayout::kBase, ParameterLayout::kReflector * layout.reflectors)
      .setConstant(prior.reflector_mm);
  for (int i = 0; i < layout.joints; ++i) {
    scale.segment<ParameterLayout::kLink>(layout.link(i)) << prior.length_mm, prior.angle_rad,
        prior.length_mm, prior.angle_rad, prior.angle_rad;
  }
  return scale;  // coefficients of deviations are left as they are: 0, known
}

}  // namespace

DesignProblem::DesignProblem(const CalibratedCell& cell, std::span<const JointVector> candidates,
                             std::span<const JointVector> task, const MeasurementNoise& noise,
                             const DesignPrior& prior)
    : candidates_{candidates.size()} {
  const Eigen::VectorXd scale = scales(cell, prior);
  task_rows_ = position_jacobian(cell, task) * scale.asDiagonal();
  task_ = gram(task_rows_) / static_cast<double>(task.size());

  const auto columns = static_cast<std::size_t>(scale.size());
  blocks_.assign((candidates_ + kMostLanes - 1) / kMostLanes * 3 * columns, {});
  PointJacobian J;
  for (std::size_t k = 0; k < candidates_; ++k) {
    const Eigen::Vector3d p_WS_mm = predict_with_jacobian(cell, candidates[k], 0, J);
    const PoseRows whitened =
        times(inverse_cholesky(reading_covariance(p_WS_mm, noise)), J * scale.asDiagonal());
    kernels::Line* block = &blocks_[k / kMostLanes * 3 * columns];
    for (std::size_t i = 0; i < 3 * columns; ++i) {
      block[i].value[k % kMostLanes] =
          whitened(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns));
    }
  }
}

Eigen::Matrix<double, 3, Eigen::Dynamic> DesignProblem::rows(std::size_t candidate) const {
  PoseRows rows(3, parameters());
  const auto columns = static_cast<std::size_t>(parameters());
  const kernels::Line* block = &blocks_[candidate / kMostLanes * 3 * columns];
  for (std::size_t i = 0; i < 3 * columns; ++i) {
    rows(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns)) =
        block[i].value[candidate % kMostLanes];
  }
  return rows;
}

}  // namespace truepose
