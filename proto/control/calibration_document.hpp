#pragma once

#include <boost/json/fwd.hpp>

#include "core/identify/calibrate.hpp"

namespace truepose::control {

/// Error statistics as every document of ours carries them, mm:
/// {"mean","rms","max","min","std","x":{"mean_abs","rms","max"},"y":{..},"z":{..}}.
boost::json::object statistics_json(const ErrorStatistics& statistics);

/// The errors of one set of points as documents carry them: {"poses","points","before","geometric","after"}.
boost::json::object stages_json(const StageErrors& stages);

/// The JSON document of one calibration, mm and rad.
///
/// After the members of the contract come "arm", the nominal one (arm_document()), and "points", one object
/// per measurement in the order of `data.points`:
/// {"pose","set","smr","joints","position"[,"sigma","direction","time"],"before","geometric","after"}. "pose"
/// counts from 1, and points with the same joints have the same; from "set" to "time" it is the row of a
/// measurement file: "joints" are deg (mm for a prismatic joint), "position" is [x, y, z] in the tracker
/// frame; the errors are [x, y, z], predicted minus measured, in the tracker frame. "validate" is there only
/// where something was validated, "rank_gap" only where a parameter could not be determined, "transfer"
/// (transfer_json()) only where the covariance is known. The schema is report.schema.json.
///
/// @param data       the measurements that `calibration` came from
/// @param elapsed_s  time that the identification took
boost::json::object calibration_document(const Calibration& calibration, const MeasurementData& data,
                                         double elapsed_s);

}  // namespace truepose::control
