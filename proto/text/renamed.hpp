#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

/// Names of keys, parameters, options and their values that were renamed before the first release. Every
/// reader that refuses an unknown name asks here, so that a file or script with an old name is refused with
/// the new one.
namespace truepose {

struct Renamed {
  std::string_view old_name, new_name;
};

inline constexpr std::array kRenamed{
    // Cell files and scenarios
    Renamed{"placement", "robot_base"},
    Renamed{"initialise_again_min", "reinitialise_after_min"},
    Renamed{"search_first_mm", "first_search_radius_mm"},
    Renamed{"search_mm", "search_radius_mm"},
    Renamed{"singular_deg", "singularity_threshold_deg"},
    Renamed{"wrist_margin_deg", "singularity_margin_deg"},
    Renamed{"most_files", "max_files"},
    Renamed{"most_mb", "max_mb"},
    Renamed{"deviation", "non_geometric"},
    Renamed{"screened", "outlier-rejection"},
    Renamed{"growth_ppm", "expansion_ppm"},
    Renamed{"rsi-garble", "rsi-corrupt"},
    // Options of the command line
    Renamed{"--deviation", "--non-geometric"},
    Renamed{"--singular-below", "--singularity-threshold"},
    Renamed{"--singular-bound", "--singularity-limit"},
    Renamed{"--largest-correction", "--max-correction"},
    Renamed{"--most-residual", "--max-orientation-residual"},
    Renamed{"--most-residual-mm", "--max-position-residual"},
    Renamed{"--known", "--nominal"},
    Renamed{"--unit", "--units"},
    // Parameters of the control protocol and of truepose-proxy
    Renamed{"known", "nominal"},
    Renamed{"garble", "corrupt"},
    Renamed{"join_ms", "coalesce_ms"},
    // Documents
    Renamed{"growth_ppm_per_k", "expansion_ppm_per_k"},
    Renamed{"far_validation", "validation_outliers"},
    Renamed{"unknown", "not_identifiable"},
    Renamed{"weak", "weakly_identifiable"},
    Renamed{"turns", "orientation_errors"},
    Renamed{"turn_rad", "orientation_error_rad"},
    Renamed{"turn_error_deg", "orientation_error_deg"},
    Renamed{"transfer", "prediction_uncertainty"},
    Renamed{"doubt", "warning"},
    Renamed{"refusal", "error"},
    Renamed{"distance2", "chi2"},
    Renamed{"degrees", "degrees_of_freedom"},
    Renamed{"probability", "p_value"},
    Renamed{"wrong", "rejected"},
    Renamed{"doubts", "warnings"},
    Renamed{"left_out", "leave_one_out"},
    Renamed{"doubtful", "outliers"},
    Renamed{"misfit_mm", "residual_mm"},
    Renamed{"is_real", "significant"},
    Renamed{"drawn", "nominal"},
    Renamed{"found", "value"},
    Renamed{"unproven", "unconfirmed"},
};

/// ", renamed to 'x'" where the name is the old one of x, which is known; empty where it is not.
template <class Names>
std::string renamed(std::string_view name, const Names& known) {
  for (const Renamed& each : kRenamed)
    if (each.old_name == name && std::ranges::find(known, each.new_name) != known.end())
      return ", renamed to '" + std::string{each.new_name} + "'";
  return {};
}

}  // namespace truepose
