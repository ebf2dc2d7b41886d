#pragma once

#include <boost/json/fwd.hpp>
#include <string>

#include "core/identify/calibrate.hpp"

namespace truepose::control {

/// Where the fit predicts worse than the nominal arm errs, in one sentence: which joints were measured over a
/// part of their range alone, where it is worst and what to do. Empty where it predicts better everywhere.
std::string transfer_warning(const Calibration& calibration, const MeasurementData& data);

/// How well unmeasured poses are known, one standard deviation of the first reflector's position (mm):
/// {"rms_mm","max_mm","worst_joints","warning","maps"}. "warning" is there only where there is something to
/// warn of.
///
/// "maps" sample the standard deviation where two joints sweep their limits and the others are held at the
/// median of the poses that identified: joints 2 and 3 (the arm's vertical plane), and 1 and 2. Each is
/// {"x","y","held","sigma_mm"}: "x" and "y" {"joint","from","to","count"}, joints counted from 1; "held" the
/// positions of all joints, of which those two do not count; "sigma_mm" one array for each y, of one number
/// for each x. Joint positions are deg, mm for a prismatic joint.
boost::json::object transfer_json(const Calibration& calibration, const MeasurementData& data);

}  // namespace truepose::control
