#pragma once

#include <boost/json/fwd.hpp>

#include "tools/experiment/experiment.hpp"

namespace truepose::tools {

/// The JSON document of one experiment, mm: {"seed","trials","noise","bound_rms",
/// "methods":[{"method","data","validation":S,"quartiles":[lower,median,upper],"rmse_over_bound","converged",
/// "iterations","time_s","within_2_percent_of_oracle","convergence":[..]}],
/// "designs":[{"design","poses","rms","max"}],
/// "layers":[{"layer","rigid","poses","backlash_deg","validation":S,"model_rms"}],
/// "published":[{"figure","source","published_mean","mean","explanation"}]}.
///
/// "rmse_over_bound" is null without noise, "within_2_percent_of_oracle" is there with gross errors alone. S
/// is record::statistics_json; of a method that never converged it is null, as are its quartiles.
boost::json::object experiment_document(const ExperimentOptions& options, const ExperimentResult& result);

}  // namespace truepose::tools
