#pragma once

#include <boost/json/array.hpp>

#include "config/scenario.hpp"

namespace truepose::world {

/// How far a model's reflector is from the true arm's, mm, mean over a hundred poses, wherever the tracker
/// stands.
///
/// Computed by itself, from the parameters that the daemon reports.
/// @param parameters  of model.get
double mean_error_mm(const boost::json::array& parameters, const config::Scenario& truth);

}  // namespace truepose::world
