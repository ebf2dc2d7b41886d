#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/fit/least_squares_problem.hpp"

namespace truepose {

/// What a fit knows of its parameters, in the order of ParameterLayout. Parameters that were held have
/// variance 0, and so have directions that the data cannot tell (their combination with others is what is
/// known).
struct ParameterUncertainty {
  Eigen::MatrixXd covariance;  ///< mm, rad
  Eigen::VectorXd data_share;  ///< 1: all that is known comes from the data; 0: all from the prior, or held
  double sigma0_mm = 0;        ///< estimated standard deviation of one coordinate of a whitened residual
  double determined = 0;       ///< how many parameters the data determine
};

/// @param system     at the solution, of the free parameters of the problem: the coordinates that took part
///                   (points of weight 0 do not), then the prior
/// @param equations  how many coordinates that is, more than the data determine
ParameterUncertainty uncertainty_of(const LinearSystem& system, const LeastSquaresProblem& problem,
                                    int parameters, int equations);

/// What the residual field leaves open of where a point of the flange is: mm^2, tracker frame of the station.
Eigen::Matrix3d field_covariance(const CalibratedCell& cell, const JointVector& q,
                                 const Eigen::Vector3d& p_F_mm, Approach approach = {}, int station = 0);

/// Covariance (mm^2, tracker frame of the station) of a predicted reflector position: what parameters and
/// residual field leave open.
Eigen::Matrix3d position_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                    const JointVector& q, int smr, Approach approach = {}, int station = 0);

/// Poses spread evenly over the joint limits (revolute joints: at most one turn), the same for the same seed.
std::vector<JointVector> poses_within_limits(const RobotModel& robot, int count, std::uint64_t seed);

/// How well a fit predicts where nothing was measured: standard deviations (mm, length of the vector) of the
/// first reflector over some poses.
struct TransferUncertainty {
  double rms_mm = 0;
  double max_mm = 0;
  JointVector worst;  ///< the pose of max_mm
};
TransferUncertainty transfer_uncertainty(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                         std::span<const JointVector> poses);

}  // namespace truepose
