#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Jacobian of a reflector's predicted position: 3 x ParameterLayout::size(), mm per mm or rad.
using PointJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// Where the tracker should see reflector `smr` at joints `q` from a station (p_WS, mm), and its derivative
/// to every parameter.
///
/// Every column is a cross product or an axis: of frame i-1 and i with the lever arm to the target, in the
/// tracker frame. The residual field is not regarded: it is fitted to what the parameters leave. Source:
/// method's paper, eqs 7 to 11, with beta first and the lever arm ending at the target.
Eigen::Vector3d predict_with_jacobian(const CalibratedCell& cell, const JointVector& q, int smr,
                                      PointJacobian& J, Approach approach = {}, int station = 0);

/// How the flange is turned in the tracker frame, and how it turns with each parameter: rad per mm or rad,
/// about the axes of that frame. As predict_with_jacobian() has it of a position.
Eigen::Matrix3d turn_with_jacobian(const CalibratedCell& cell, const JointVector& q, PointJacobian& J,
                                   Approach approach = {}, int station = 0);

/// The same of the first reflector at many poses, by the kernels: positions (3N, mm) and rows
/// (3N x ParameterLayout::size()), three a pose.
void predict_with_jacobian(const CalibratedCell& cell, std::span<const JointVector> poses,
                           Eigen::VectorXd& p_WS_mm, Eigen::MatrixXd& J);

/// Variances of where the first reflector is predicted at many poses, those of the three coordinates added
/// up (mm^2).
///
/// @param covariance  of the parameters, in the order of ParameterLayout
Eigen::VectorXd position_variances(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                   std::span<const JointVector> poses);

/// forward_kinematics() at every point, deviations and field included, all together by the kernels.
std::vector<Eigen::Isometry3d> flange_poses(const RobotModel& robot, std::span<const Measurement> points);

/// Predicted minus measured positions of all points, each in the frame of its station, stacked (3N, mm).
Eigen::VectorXd residuals(const CalibratedCell& cell, std::span<const Measurement> points);

/// residuals() of the same points again and again, at cells that differ in their parameters alone: what the
/// deviations of the joints depend on is worked out once.
class RepeatedResiduals {
 public:
  /// @param points  must outlive it
  RepeatedResiduals(const RobotModel& robot, std::span<const Measurement> points);

  /// Those at `cell`, whose arm is `robot` but for its parameters (3N, mm).
  Eigen::VectorXd at(const CalibratedCell& cell) const;

 private:
  std::span<const Measurement> points_;
  Eigen::MatrixXd bases_;  ///< of each deviation, a column per point
};

/// residuals() with the derivative to every parameter (3N x ParameterLayout::size()).
void residuals_with_jacobian(const CalibratedCell& cell, std::span<const Measurement> points,
                             Eigen::VectorXd& f, Eigen::MatrixXd& J);
/// The same with some columns alone, in the order of `parameters`, each of which is there once.
void residuals_with_jacobian(const CalibratedCell& cell, std::span<const Measurement> points,
                             std::span<const int> parameters, Eigen::VectorXd& f, Eigen::MatrixXd& J);

}  // namespace truepose
