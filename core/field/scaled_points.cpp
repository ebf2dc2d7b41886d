#include "core/field/scaled_points.hpp"

namespace truepose {

FeatureScale::FeatureScale(const Eigen::MatrixXd& X) : mean_{X.colwise().mean().transpose()} {
  const Eigen::VectorXd spread =
      ((X.rowwise() - mean_.transpose()).colwise().squaredNorm() / static_cast<double>(X.rows())).cwiseSqrt();
  const Eigen::VectorXd smallest = 1e-12 * (mean_.cwiseAbs().array() + 1).matrix();
  inverse_spread_ = (spread.array() > smallest.array()).select(spread.cwiseInverse(), 0.0);
}

Eigen::MatrixXd FeatureScale::apply_all(const Eigen::MatrixXd& X) const {
  return (X.rowwise() - mean_.transpose()) * inverse_spread_.asDiagonal();
}

Eigen::VectorXd target_scale(const Eigen::MatrixXd& Y) {
  const Eigen::VectorXd rms = (Y.colwise().squaredNorm() / static_cast<double>(Y.rows())).cwiseSqrt();
  return (rms.array() > 0).select(rms, 1.0);
}

BlockedPoints::BlockedPoints(const Eigen::MatrixXd& Z) {
  const Eigen::Index rows = (Z.rows() + kBlock - 1) / kBlock * kBlock;
  Z_ = Eigen::MatrixXd::Constant(rows, Z.cols(), 1e100);
  Z_.topRows(Z.rows()) = Z;
}

}  // namespace truepose
