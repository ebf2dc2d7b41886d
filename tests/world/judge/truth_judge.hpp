#pragma once

#include <Eigen/Core>
#include <boost/json/array.hpp>
#include <string>

#include "config/scenario.hpp"

namespace truepose::world {

/// Where a reflector of the true arm is, mm in the frame of a tracker that has not moved, but for the arm's
/// repeatability. Computed by itself.
/// @param reflector  its name: "1" or "2"
Eigen::Vector3d true_point_mm(const JointVector& q_rad, const std::string& reflector,
                              const config::Scenario& truth);

/// How far a model's reflector is from the true arm's, mm, mean over a hundred poses, wherever the tracker
/// stands.
///
/// Computed by itself, from the parameters that the daemon reports.
/// @param parameters  of model.get
double mean_error_mm(const boost::json::array& parameters, const config::Scenario& truth);

}  // namespace truepose::world
