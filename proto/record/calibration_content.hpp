#pragma once

#include <boost/json/fwd.hpp>
#include <string>

#include "core/calibrate/calibrate_options.hpp"
#include "core/calibrate/calibration.hpp"
#include "proto/record/calibration_document.hpp"

namespace truepose::record {

/// The document of what a calibration found.
///
/// @param data       the measurements that `calibration` came from
/// @param elapsed_s  time that the identification took
CalibrationDocument calibration_of(const Calibration& calibration, const MeasurementData& data,
                                   double elapsed_s);
boost::json::object calibration_document(const Calibration& calibration, const MeasurementData& data,
                                         double elapsed_s);

/// How a calibration was made, in words, for whom reads its document later: {"Loss": "squared", ...}.
ByName<std::string> options_in_words(const CalibrateOptions& options);

}  // namespace truepose::record
