#pragma once

#include <Eigen/Core>
#include <boost/json/array.hpp>

#include "config/scenario.hpp"

namespace truepose::world {

/// Where the reflector of the true arm is, mm in the frame of a tracker that has not moved, but for the arm's
/// repeatability. Computed by itself.
Eigen::Vector3d true_point_mm(const JointVector& q_rad, const config::Scenario& truth);

/// How far a model's reflector is from the true arm's, mm, mean over a hundred poses, wherever the tracker
/// stands.
///
/// Computed by itself, from the parameters that the daemon reports.
/// @param parameters  of model.get
double mean_error_mm(const boost::json::array& parameters, const config::Scenario& truth);

}  // namespace truepose::world
