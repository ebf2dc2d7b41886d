#pragma once

#include <span>
#include <string>

#include "core/calibration/calibrate.hpp"

namespace truepose::config {

/// The identified parameters as CSV: name,unit,nominal,value,deviation,sigma,identified, every number with
/// the digits that bring it back exactly. Empty fields: nominal and deviation of base and reflectors, which
/// have no data sheet, and sigma of what was not identified.
std::string parameter_csv(std::span<const IdentifiedParameter> parameters);

}  // namespace truepose::config
