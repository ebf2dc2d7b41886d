#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// One self-contained HTML page (well-formed XML, no script, no external file) of a calibration document.
///
/// @param document  control::calibration_document, optionally extended by
///   "remeasured": S, "remeasured_points": [{"pose","smr","error":[x,y,z]}] (pose as in "points", mm, in the
///   tracker's frame, wanted minus measured),
///   "stream":
///   {"cycles","answered","late","wrong_ipoc","max_step_deg","turnaround_us":{"p50","p99","p999","max"}},
///   "truth": {"base":{x,y,z,rx,ry,rz}, "smr":{x,y,z}, "links":[{"a","alpha","d","theta","beta"}]}, the
///   values (not the deviations) of a simulated arm, mm and rad; "smr" may also hold {x,y,z} by the
///   reflector's name; "robot", "tracker", "campaign": texts that say which; "spread" and "fold_points" of a
///   validation in several runs; "noise": {"range_mm","transverse_mm_per_m","repeatability_mm"}. What a
///   document does not hold has no section.
/// Throws std::invalid_argument with one sentence where a member is missing or of the wrong kind.
std::string render_html(const boost::json::object& document);

}  // namespace truepose::report
