#include "core/fit/measurement_model.hpp"

#include <algorithm>
#include <vector>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/guide.hpp"
#include "core/arm/robot_model.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/prepared_points.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// The frames of an arm's links in the tracker frame, and those of its joints: where a guide displaces the
/// link, before it does.
struct TrackedFrames {
  LinkFrames links;  ///< 0 (the base) to N
  LinkFrames joints;

  TrackedFrames(const RobotModel& robot, const Eigen::Isometry3d& X_WB, const JointVector& q,
                Approach approach) {
    link_frames(robot, true_joints(robot, q, approach), links);
    displace_by_guides(robot, q, links);
    const auto guided = guided_joints(robot);
    for (std::size_t i = 0; i <= robot.joints.size(); ++i) {
      links[i] = X_WB * links[i];
      joints[i] = links[i];
      if (i == 0 || !guided[i - 1]) continue;
      joints[i] = links[i] * inverse_of(guide_frames(robot, static_cast<int>(i) - 1, q).back());
    }
  }
};

/// How a point at P moves along or turns about an axis of a frame.
Eigen::Vector3d motion_along(const Eigen::Isometry3d& X, int axis) { return X.linear().col(axis); }
Eigen::Vector3d motion_about(const Eigen::Isometry3d& X, int axis, const Eigen::Vector3d& P) {
  return X.linear().col(axis).cross(P - X.translation());
}

/// A deviation moves its joint, or a motion of its guide.
Eigen::Vector3d deviation_column(const RobotModel& robot, const DeviationTerm& term, const TrackedFrames& X,
                                 const JointVector& q, const Eigen::Vector3d& P) {
  Eigen::Isometry3d moved = X.joints[static_cast<std::size_t>(term.joint) + 1];
  const int motion = guide_motion(term.basis);
  const bool along = moves_along(robot, term);
  if (motion < 0) {
    const double sign = robot.joints[static_cast<std::size_t>(term.joint)].sign;
    return sign * (along ? motion_along(moved, 2) : motion_about(moved, 2, P));
  }
  const auto m = static_cast<std::size_t>(motion);
  moved = moved * guide_frames(robot, term.joint, q)[m];
  const int axis = kGuideMotions[m].axis;
  return along ? motion_along(moved, axis) : motion_about(moved, axis, P);
}

/// The axis about which a deviation turns what follows it; zero where it moves along.
Eigen::Vector3d deviation_axis(const RobotModel& robot, const DeviationTerm& term, const TrackedFrames& X,
                               const JointVector& q) {
  if (moves_along(robot, term)) return Eigen::Vector3d::Zero();
  const Eigen::Isometry3d& joint = X.joints[static_cast<std::size_t>(term.joint) + 1];
  const int motion = guide_motion(term.basis);
  if (motion < 0) return robot.joints[static_cast<std::size_t>(term.joint)].sign * motion_along(joint, 2);
  const auto m = static_cast<std::size_t>(motion);
  return motion_along(joint * guide_frames(robot, term.joint, q)[m], kGuideMotions[m].axis);
}

/// The common normal that follows a link's beta: about it alpha turns, along it a moves.
Eigen::Vector3d normal_of(const Joint& joint, const Eigen::Isometry3d& before) {
  return before.linear() *
         (Eigen::AngleAxisd(joint.beta_rad, Eigen::Vector3d::UnitY()) * Eigen::Vector3d::UnitX());
}

}  // namespace

Eigen::Vector3d predict_with_jacobian(const CalibratedCell& cell, const JointVector& q, int smr,
                                      PointJacobian& J, Approach approach, int station) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const Eigen::Isometry3d X_WB = cell.base_at(station).isometry();
  const TrackedFrames X(cell.robot, X_WB, q, approach);
  const Eigen::Isometry3d X_WF = X.links[cell.robot.joints.size()] * cell.robot.X_flange;
  const Eigen::Vector3d P = X_WF * cell.reflectors[static_cast<std::size_t>(smr)].p_FS_mm;

  J.setZero(3, layout.size());
  const int base = layout.base(station);
  J.middleCols<3>(base).setIdentity();
  const Eigen::Vector3d lever = P - X_WB.translation();
  for (int k = 0; k < 3; ++k) J.col(base + 3 + k) = Eigen::Vector3d::Unit(k).cross(lever);
  J.middleCols<3>(layout.reflector(smr)) = X_WF.linear();

  for (int i = 0; i < layout.joints; ++i) {
    const auto link = static_cast<std::size_t>(i);
    const Eigen::Isometry3d &before = X.links[link], &after = X.joints[link + 1];
    const Eigen::Vector3d from_before = P - before.translation();
    const Eigen::Vector3d x = normal_of(cell.robot.joints[link], before);
    auto columns = J.middleCols<5>(layout.link(i));
    columns.col(0) = x;
    columns.col(1) = x.cross(from_before);
    columns.col(2) = motion_along(after, 2);
    columns.col(3) = motion_about(after, 2, P);
    columns.col(4) = motion_about(before, 1, P);
  }
  std::vector<double> basis(cell.robot.deviation.size());
  deviation_basis(cell.robot, q, approach, basis);
  for (std::size_t t = 0; t < basis.size(); ++t)
    J.col(layout.deviation(static_cast<int>(t))) =
        basis[t] * deviation_column(cell.robot, cell.robot.deviation[t], X, q, P);
  return P;
}

Eigen::Matrix3d turn_with_jacobian(const CalibratedCell& cell, const JointVector& q, PointJacobian& J,
                                   Approach approach, int station) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const TrackedFrames X(cell.robot, cell.base_at(station).isometry(), q, approach);
  J.setZero(3, layout.size());
  J.middleCols<3>(layout.base(station) + 3).setIdentity();
  for (int i = 0; i < layout.joints; ++i) {
    const auto link = static_cast<std::size_t>(i);
    auto columns = J.middleCols<5>(layout.link(i));
    columns.col(1) = normal_of(cell.robot.joints[link], X.links[link]);
    columns.col(3) = motion_along(X.joints[link + 1], 2);
    columns.col(4) = motion_along(X.links[link], 1);
  }
  std::vector<double> basis(cell.robot.deviation.size());
  deviation_basis(cell.robot, q, approach, basis);
  for (std::size_t t = 0; t < basis.size(); ++t)
    J.col(layout.deviation(static_cast<int>(t))) =
        basis[t] * deviation_axis(cell.robot, cell.robot.deviation[t], X, q);
  return X.links[cell.robot.joints.size()].linear() * cell.robot.X_flange.linear();
}

namespace {

/// @param joints_of  the true joints of the point of that number
template <typename JointsOf>
std::vector<Eigen::Isometry3d> flange_poses(const RobotModel& robot, std::span<const Measurement> points,
                                            JointsOf joints_of) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::ArrayXXd q(count, robot.joint_count());
  for (Eigen::Index n = 0; n < count; ++n) q.row(n) = joints_of(static_cast<std::size_t>(n)).transpose();
  PoseColumns columns(count, 12);
  ArmKernel{robot}.forward(q, columns);
  const bool moved = is_displaced(robot);
  std::vector<Eigen::Isometry3d> X_BF(points.size(), Eigen::Isometry3d::Identity());
  for (Eigen::Index n = 0; n < count; ++n) {
    Eigen::Isometry3d& X = X_BF[static_cast<std::size_t>(n)];
    for (int axis = 0; axis < 4; ++axis) X.matrix().col(axis).head<3>() = columns.row(n).segment<3>(3 * axis);
    if (moved) X = displaced(robot, points[static_cast<std::size_t>(n)].q, q.row(n).transpose(), X);
  }
  return X_BF;
}

Eigen::VectorXd residuals(const CalibratedCell& cell, std::span<const Measurement> points,
                          const std::vector<Eigen::Isometry3d>& X_BF) {
  Eigen::VectorXd f(3 * static_cast<Eigen::Index>(points.size()));
  std::vector<Eigen::Isometry3d> X_WB;
  for (int s = 0; s < cell.station_count(); ++s) X_WB.push_back(cell.base_at(s).isometry());
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Eigen::Vector3d& p_FS_mm = cell.reflectors[static_cast<std::size_t>(points[n].smr)].p_FS_mm;
    f.segment<3>(3 * static_cast<Eigen::Index>(n)) =
        transformed(X_WB[static_cast<std::size_t>(points[n].station)], transformed(X_BF[n], p_FS_mm)) -
        points[n].p_WS_mm;
  }
  return f;
}

}  // namespace

std::vector<Eigen::Isometry3d> flange_poses(const RobotModel& robot, std::span<const Measurement> points) {
  LoadedArm arm(robot);
  return flange_poses(robot, points, [&](std::size_t n) {
    return true_joints(arm.at(points[n]), points[n].q, points[n].direction);
  });
}

Eigen::VectorXd residuals(const CalibratedCell& cell, std::span<const Measurement> points) {
  return residuals(cell, points, flange_poses(cell.robot, points));
}

RepeatedResiduals::RepeatedResiduals(const RobotModel& robot, std::span<const Measurement> points)
    : points_{points},
      bases_(static_cast<Eigen::Index>(robot.deviation.size()), static_cast<Eigen::Index>(points.size())) {
  LoadedArm arm(robot);
  for (std::size_t n = 0; n < points.size() && bases_.rows() > 0; ++n) {
    deviation_basis(arm.at(points[n]), points[n].q, points[n].direction,
                    {bases_.col(static_cast<Eigen::Index>(n)).data(), robot.deviation.size()});
  }
}

Eigen::VectorXd RepeatedResiduals::at(const CalibratedCell& cell) const {
  if (bases_follow_links(cell.robot)) return residuals(cell, points_);
  const auto joints_of = [&](std::size_t n) {
    const auto basis = bases_.col(static_cast<Eigen::Index>(n));
    return true_joints(cell.robot, points_[n].q, std::span(basis.data(), cell.robot.deviation.size()));
  };
  return residuals(cell, points_, flange_poses(cell.robot, points_, joints_of));
}

namespace {

/// Where the columns of the wanted parameters stand, in a Jacobian and among the kernels' columns.
struct WantedColumns {
  std::vector<int> place;        ///< in the Jacobian, of each parameter; -1: not wanted
  std::vector<int> along_links;  ///< wanted parameters of links and deviations: the kernels' columns in turn

  WantedColumns(const ParameterLayout& layout, std::span<const int> wanted)
      : place(static_cast<std::size_t>(layout.size()), -1) {
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      place[static_cast<std::size_t>(wanted[k])] = static_cast<int>(k);
      if (wanted[k] >= layout.link(0)) along_links.push_back(wanted[k]);
    }
  }
};

/// The kernels' columns of a chunk of one reflector's points, taken to the tracker frame and to the rows of
/// the points.
class Rows {
 public:
  Rows(const Eigen::Isometry3d& X_WB, int first_base, const ParameterLayout& layout,
       const WantedColumns& wanted, Eigen::VectorXd& f, Eigen::MatrixXd& J)
      : R_WB_{X_WB.linear()}, base_{first_base}, layout_{layout}, wanted_{wanted}, f_{f}, J_{J} {}

  /// @param columns  of `count` points
  /// @param rows     first row of each of them; -1 where it is padding
  void put(const double* columns, int count, std::span<const Eigen::Index> rows, int reflector) {
    for (int k = 0; k < count; ++k) {
      const Eigen::Index row = rows[static_cast<std::size_t>(k)];
      if (row < 0) continue;
      const auto local = [&](int column) {
        const double* const at = columns + 3 * kernels::kChunk * column + k;
        return Eigen::Vector3d(at[0], at[count], at[2 * count]);
      };
      f_.segment<3>(row) = R_WB_ * local(0);
      Eigen::Matrix3d turns, of_reflector;
      for (int axis = 0; axis < 3; ++axis) {
        turns.col(axis) = local(1 + axis);
        of_reflector.col(axis) = local(4 + axis);
      }
      put_three(row, base_, Eigen::Matrix3d::Identity());
      put_three(row, base_ + 3, R_WB_ * turns * R_WB_.transpose());
      put_three(row, layout_.reflector(reflector), R_WB_ * of_reflector);
    }
    const double* column = columns + 3 * kernels::kChunk * kernels::kFixedColumns;
    for (const int parameter : wanted_.along_links) {
      double* const to = J_.col(place_of(parameter)).data();
      for (int k = 0; k < count; ++k) {
        const Eigen::Index row = rows[static_cast<std::size_t>(k)];
        if (row < 0) continue;
        Eigen::Map<Eigen::Vector3d>(to + row) =
            R_WB_ * Eigen::Vector3d(column[k], column[count + k], column[2 * count + k]);
      }
      column += 3 * kernels::kChunk;
    }
  }

 private:
  int place_of(int parameter) const { return wanted_.place[static_cast<std::size_t>(parameter)]; }

  void put_three(Eigen::Index row, int first, const Eigen::Matrix3d& derivative) {
    for (int k = 0; k < 3; ++k)
      if (const int place = place_of(first + k); place >= 0) J_.block<3, 1>(row, place) = derivative.col(k);
  }

  Eigen::Matrix3d R_WB_;
  int base_;
  const ParameterLayout& layout_;
  const WantedColumns& wanted_;
  Eigen::VectorXd& f_;
  Eigen::MatrixXd& J_;
};

}  // namespace

void residuals_with_jacobian(const CalibratedCell& cell, std::span<const Measurement> points,
                             Eigen::VectorXd& f, Eigen::MatrixXd& J) {
  residuals_with_jacobian(cell, points, first_parameters(ParameterLayout::of(cell).size()), f, J);
}

void residuals_with_jacobian(const CalibratedCell& cell, std::span<const Measurement> points,
                             std::span<const int> parameters, Eigen::VectorXd& f, Eigen::MatrixXd& J) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const WantedColumns wanted(layout, parameters);
  f.resize(3 * static_cast<Eigen::Index>(points.size()));
  J.setZero(f.size(), static_cast<Eigen::Index>(parameters.size()));
  std::vector<kernels::LinkColumn> columns;
  for (const int parameter : wanted.along_links)
    columns.push_back(link_column(cell.robot, layout, parameter));
  const PreparedPoints prepared(cell.robot, points, layout.reflectors);
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(prepared.end()), -1);
  for (std::size_t n = 0; n < points.size(); ++n)
    rows[static_cast<std::size_t>(prepared.places()[n])] = 3 * static_cast<Eigen::Index>(n);

  PreparedModel model(cell, columns);
  std::vector<kernels::Line> chunk((kernels::kFixedColumns + columns.size()) * 3 * kernels::kChunk /
                                   kernels::kMostLanes);
  for (int s = 0; s < prepared.stations(); ++s) {
    const Eigen::Isometry3d X_WB = cell.base_at(s).isometry();
    Rows out(X_WB, layout.base(s), layout, wanted, f, J);
    for (int k = 0; k < layout.reflectors; ++k) {
      const kernels::PointModel& seen = model.of(X_WB, cell.reflectors[static_cast<std::size_t>(k)]);
      const kernels::PointBlock block = prepared.of(s, k);
      for (int first = 0; first < block.count; first += kernels::kChunk) {
        const int count = std::min(kernels::kChunk, block.count - first);
        prepared.code().point_columns(seen, block, first, chunk[0].value);
        out.put(chunk[0].value, count,
                std::span(rows).subspan(static_cast<std::size_t>(prepared.first_of(s, k) + first)), k);
      }
    }
  }
}

void predict_with_jacobian(const CalibratedCell& cell, std::span<const JointVector> poses,
                           Eigen::VectorXd& p_WS_mm, Eigen::MatrixXd& J) {
  std::vector<Measurement> points;  // read at the origin, so that their residuals are the positions
  points.reserve(poses.size());
  for (const JointVector& q : poses) points.push_back({.q = q, .p_WS_mm = Eigen::Vector3d::Zero()});
  residuals_with_jacobian(cell, points, p_WS_mm, J);
}

namespace {

/// The kernels' local columns of the first reflector, without the residual: the base's turns, the reflector,
/// the links that vary, the base's translations, all along the base's own axes.
struct LocalColumns {
  std::vector<kernels::LinkColumn> links;
  Eigen::MatrixXd covariance;

  LocalColumns(const CalibratedCell& cell, const Eigen::MatrixXd& of_all) {
    const ParameterLayout layout = ParameterLayout::of(cell);
    const int turn = layout.base(0) + 3, reflector = layout.reflector(0), shift = layout.base(0);
    std::vector<int> parameters{turn, turn + 1, turn + 2, reflector, reflector + 1, reflector + 2};
    for (int k = layout.link(0); k < layout.size(); ++k) {
      if (!(of_all(k, k) > 0)) continue;
      parameters.push_back(k);
      links.push_back(link_column(cell.robot, layout, k));
    }
    parameters.insert(parameters.end(), {shift, shift + 1, shift + 2});
    covariance = of_all(parameters, parameters);
    const Eigen::Matrix3d R_BW = cell.base.isometry().linear().transpose();
    for (const Eigen::Index first : {Eigen::Index{0}, covariance.rows() - 3}) {
      covariance.middleRows<3>(first) = (R_BW * covariance.middleRows<3>(first)).eval();
      covariance.middleCols<3>(first) = (covariance.middleCols<3>(first) * R_BW.transpose()).eval();
    }
  }
};

}  // namespace

Eigen::VectorXd position_variances(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                   std::span<const JointVector> poses) {
  constexpr int kStride = 3 * kernels::kChunk;
  const LocalColumns local(cell, covariance);
  std::vector<Measurement> points;
  points.reserve(poses.size());
  for (const JointVector& q : poses) points.push_back({.q = q});
  const PreparedPoints prepared(cell.robot, points, 1);
  PreparedModel model(cell, local.links);
  const kernels::PointModel& seen = model.of(Eigen::Isometry3d::Identity(), cell.reflectors.front());
  const kernels::PointBlock block = prepared.of(0, 0);
  const Eigen::Index columns = local.covariance.cols();
  std::vector<kernels::Line> chunk(static_cast<std::size_t>(1 + columns) * kStride / kernels::kMostLanes);
  Eigen::VectorXd variances(block.count);
  for (int first = 0; first < block.count; first += kernels::kChunk) {
    const int count = std::min(kernels::kChunk, block.count - first);
    prepared.code().point_columns(seen, block, first, chunk[0].value);
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> J(chunk[0].value + kStride, 3 * count, columns,
                                                           Eigen::OuterStride<>(kStride));
    J.rightCols<3>().setZero();
    for (int axis = 0; axis < 3; ++axis) J.col(columns - 3 + axis).segment(axis * count, count).setOnes();
    variances.segment(first, count) =
        congruence_diagonal(J, local.covariance).reshaped(count, 3).rowwise().sum();
  }
  return variances.head(static_cast<Eigen::Index>(poses.size()));
}

}  // namespace truepose
