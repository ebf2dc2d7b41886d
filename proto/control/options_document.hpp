#pragma once

#include <boost/json/fwd.hpp>

#include "core/identify/calibrate.hpp"

namespace truepose::control {

/// How a calibration was made, in words, for whom reads its document later: {"Loss": "squared", ...}.
boost::json::object options_json(const CalibrateOptions& options);

/// {"range_mm","transverse_mm_per_m","repeatability_mm"[,"range_mm_per_m","transverse_mm"]}, one standard
/// deviation each; the last two where they are not 0.
boost::json::object noise_json(const MeasurementNoise& noise);

}  // namespace truepose::control
