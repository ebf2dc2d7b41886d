#include "core/calibration/linear_start.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/kinematics/forward.hpp"
#include "core/linear_algebra/decompositions.hpp"

namespace truepose {
namespace {

/// Of singular values beside the largest: what is below is rounding.
constexpr double kTolerance = 1e-10;

/// The rotation nearest to M.
Eigen::Matrix3d projected_to_rotation(const Eigen::Matrix3d& M) {
  const Svd svd = thin_svd(M);
  Eigen::Matrix3d U = svd.U;
  const Eigen::Matrix3d V = svd.V;
  if ((U * V.transpose()).determinant() < 0) U.col(2) *= -1;
  return U * V.transpose();
}

}  // namespace

CalibratedCell linear_start(const RobotModel& arm, std::span<const std::string> smr_names,
                            std::span<const Measurement> points) {
  const auto rows = 3 * static_cast<Eigen::Index>(points.size());
  const auto reflector_columns = 3 * static_cast<Eigen::Index>(smr_names.size());

  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Measurement& point : points) centre += point.p_WS_mm;
  centre /= static_cast<double>(points.size());
  double scale = 0;
  for (const Measurement& point : points) scale = std::max(scale, (point.p_WS_mm - centre).norm());

  std::vector<Eigen::Isometry3d> flange;
  flange.reserve(points.size());
  for (const Measurement& point : points) flange.push_back(forward_kinematics(arm, point.q));

  // Unknowns: rows of scale * R', then s about the centre, then t of each reflector.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, 12 + reflector_columns);
  Eigen::VectorXd b(rows);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto row = 3 * static_cast<Eigen::Index>(k);
    const Eigen::Vector3d c = (points[k].p_WS_mm - centre) / scale;
    for (int i = 0; i < 3; ++i) A.block<1, 3>(row + i, 3 * i) = c.transpose();
    A.block<3, 3>(row, 9) = -Eigen::Matrix3d::Identity();
    A.block<3, 3>(row, 12 + 3 * points[k].smr) = -flange[k].linear();
    b.segment<3>(row) = flange[k].translation();
  }
  const Eigen::VectorXd unknowns = smallest_solution(A, b, kTolerance);
  const Eigen::Matrix3d M = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(unknowns.data());
  const Eigen::Matrix3d R = projected_to_rotation(M.transpose());

  // R p_k + R R_k t + P = c with R known.
  Eigen::MatrixXd A_position = Eigen::MatrixXd::Zero(rows, 3 + reflector_columns);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto row = 3 * static_cast<Eigen::Index>(k);
    A_position.block<3, 3>(row, 0).setIdentity();
    A_position.block<3, 3>(row, 3 + 3 * points[k].smr) = R * flange[k].linear();
    b.segment<3>(row) = points[k].p_WS_mm - R * flange[k].translation();
  }
  const Eigen::VectorXd positions = smallest_solution(A_position, b, kTolerance);

  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = R;
  X_WB.translation() = positions.head<3>();
  CalibratedCell cell{arm, BasePose::of(X_WB), {}};
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    cell.reflectors.push_back({smr_names[k], positions.segment<3>(3 + 3 * static_cast<Eigen::Index>(k))});
  }
  return cell;
}

}  // namespace truepose
