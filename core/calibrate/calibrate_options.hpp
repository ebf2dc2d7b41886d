#pragma once

#include <optional>
#include <vector>

#include "core/choices.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/field/field_choice.hpp"
#include "core/fit/prior.hpp"
#include "core/fit/robust_fit.hpp"
#include "core/fit/warm_up.hpp"

namespace truepose {

struct CalibrateOptions {
  Loss loss = Loss::OutlierRejection;
  PriorUse prior = PriorUse::Auto;
  PriorScale prior_scale;
  std::optional<MeasurementNoise> noise;  ///< where points do not state their sigma; none: all alike
  bool non_geometric = false;             ///< look for deviations of the joints and keep those that help
  std::vector<int> harmonics{1, 2};       ///< multiples of a joint's angle to look for
  FieldUse field = FieldUse::None;        ///< over what the layers before it leave
  /// Look for what warmth does to joint zeros and lengths, and keep it where it helps.
  ThermalUse thermal = ThermalUse::Auto;
  /// Refuse a nominal arm that cannot be right, and say which mistake explains the data.
  bool check_model = true;
  std::optional<CalibratedCell> start;  ///< where the coarse stage starts; none: found without a guess
  int max_coarse_iterations = 200;
  int max_fine_iterations = 50;
  int jobs = 1;  ///< threads; the result is the same with any number
};

}  // namespace truepose
