#include "core/identify/linear_start.hpp"

#include <algorithm>
#include <cmath>

#include "core/identify/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Of pivots of normal equations beside the largest: below, the poses do not tell the unknown.
constexpr double kTolerance = 1e-12;

/// The rotation nearest to M.
Eigen::Matrix3d projected_to_rotation(const Eigen::Matrix3d& M) {
  const Svd svd = thin_svd(M);
  Eigen::Matrix3d U = svd.U;
  const Eigen::Matrix3d V = svd.V;
  if ((U * V.transpose()).determinant() < 0) U.col(2) *= -1;
  return U * V.transpose();
}

/// A point as the linear problems see it.
struct Sight {
  Eigen::Vector3d c;  ///< measured, about the centre of all
  Eigen::Isometry3d flange;
  Eigen::Index t;  ///< first of the reflector's unknowns, counted from the first reflector's
};

/// A x = b of some unknowns and the reflectors behind them, summed over points.
struct NormalSums {
  Eigen::MatrixXd A;  ///< lower half
  Eigen::VectorXd b;

  explicit NormalSums(Eigen::Index size)
      : A{Eigen::MatrixXd::Zero(size, size)}, b{Eigen::VectorXd::Zero(size)} {}
  Eigen::VectorXd solution() const {
    return smallest_solution(A.selfadjointView<Eigen::Lower>(), b, kTolerance);
  }
};

/// Rows of scale * R' (9), s (3), t of each reflector: R' c - s - R_k t = p_k.
Eigen::VectorXd affine_solution(const std::vector<Sight>& sights, double scale, Eigen::Index reflectors) {
  NormalSums sums(12 + 3 * reflectors);
  for (const Sight& sight : sights) {
    const Eigen::Vector3d c = sight.c / scale, p = sight.flange.translation();
    const Eigen::Matrix3d R = sight.flange.linear();
    const Eigen::Index t = 12 + sight.t;
    for (Eigen::Index i = 0; i < 3; ++i) {
      sums.A.block<3, 3>(3 * i, 3 * i) += c * c.transpose();
      sums.A.block<1, 3>(9 + i, 3 * i) -= c.transpose();
      sums.A.block<3, 3>(t, 3 * i) -= R.row(i).transpose() * c.transpose();
      sums.b.segment<3>(3 * i) += p[i] * c;
    }
    sums.A.block<3, 3>(9, 9) += Eigen::Matrix3d::Identity();
    sums.A.block<3, 3>(t, 9) += R.transpose();
    sums.A.block<3, 3>(t, t) += Eigen::Matrix3d::Identity();
    sums.b.segment<3>(9) -= p;
    sums.b.segment<3>(t) -= R.transpose() * p;
  }
  return sums.solution();
}

/// P and t of each reflector: P + R R_k t = c - R p_k, with R known.
Eigen::VectorXd positions_solution(const std::vector<Sight>& sights, const Eigen::Matrix3d& R_WB,
                                   Eigen::Index reflectors) {
  NormalSums sums(3 + 3 * reflectors);
  for (const Sight& sight : sights) {
    const Eigen::Matrix3d R = R_WB * sight.flange.linear();
    const Eigen::Vector3d off = sight.c - R_WB * sight.flange.translation();
    const Eigen::Index t = 3 + sight.t;
    sums.A.block<3, 3>(0, 0) += Eigen::Matrix3d::Identity();
    sums.A.block<3, 3>(t, 0) += R.transpose();
    sums.A.block<3, 3>(t, t) += Eigen::Matrix3d::Identity();
    sums.b.head<3>() += off;
    sums.b.segment<3>(t) += R.transpose() * off;
  }
  return sums.solution();
}

}  // namespace

CalibratedCell linear_start(const RobotModel& arm, std::span<const std::string> smr_names,
                            std::span<const Measurement> points) {
  const auto reflectors = static_cast<Eigen::Index>(smr_names.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Measurement& point : points) centre += point.p_WS_mm;
  centre /= static_cast<double>(points.size());

  const std::vector<Eigen::Isometry3d> flange = flange_poses(arm, points);
  std::vector<Sight> sights;
  double scale = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    sights.push_back({points[k].p_WS_mm - centre, flange[k], 3 * points[k].smr});
    scale = std::max(scale, sights.back().c.norm());
  }

  const Eigen::VectorXd unknowns = affine_solution(sights, scale, reflectors);
  const Eigen::Matrix3d M = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(unknowns.data());
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = projected_to_rotation(M.transpose());
  const Eigen::VectorXd positions = positions_solution(sights, X_WB.linear(), reflectors);
  X_WB.translation() = centre + positions.head<3>();

  CalibratedCell cell{arm, BasePose::of(X_WB), {}};
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    cell.reflectors.push_back({smr_names[k], positions.segment<3>(3 + 3 * static_cast<Eigen::Index>(k))});
  }
  return cell;
}

}  // namespace truepose
