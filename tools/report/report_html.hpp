#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// Documents that a calibration's page has sections of besides its own; null where there is none.
struct FurtherDocuments {
  const boost::json::object* iso9283 = nullptr;     ///< as `truepose iso9283 --json` prints it
  const boost::json::object* experiment = nullptr;  ///< as `truepose experiment --json` prints it
};

/// One self-contained HTML page (well-formed XML, no external file) of a calibration document. It carries the
/// documents and the measurements for download.
///
/// @param document  record::calibration_document, optionally extended by
///   "remeasured": S, "remeasured_points": [{"pose","smr","error":[x,y,z]}] (pose as in "points", mm, in the
///   tracker's frame, wanted minus measured),
///   "stream":
///   {"cycles","answered","late","wrong_ipoc","max_step_deg","turnaround_us":{"p50","p99","p999","max"}},
///   "truth": {"base":{x,y,z,rx,ry,rz}, "smr":{x,y,z}, "links":[{"a","alpha","d","theta","beta"}]}, the
///   values (not the deviations) of a simulated arm, mm and rad; "smr" may also hold {x,y,z} by the
///   reflector's name; "robot", "tracker", "campaign", "model": texts that say which; "date" (RFC 3339);
///   "spread" and "fold_points" of a validation in several runs; "noise":
///   {"range_mm","transverse_mm_per_m","repeatability_mm"}; "conditions" and "skipped" of a campaign;
///   "reference_drift_mm": [mm]; "options" and "files": texts by what they are. report.schema.json has it
///   all. What a document does not hold has no section.
/// Throws std::invalid_argument with one sentence where a member of it is missing or of the wrong kind, and
/// boost::system::system_error where one of a further document is.
std::string render_html(const boost::json::object& document, const FurtherDocuments& further = {});

}  // namespace truepose::report
