#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/report/report.hpp"

namespace truepose::report {

// The sections of a calibration's page, in its order. Each is empty where the document has nothing for it.

/// What is read in ten seconds: the error before and after, and the verdict.
std::string summary_section(const ReportDocument& document);
/// The table of errors through the stages.
std::string statistics_section(const ReportDocument& document);
/// Empty where no target showed an orientation.
std::string turns_section(const ReportDocument& document);
/// How a production program went with the correction and without it.
std::string production_section(const ReportDocument& document);
/// What was measured, with what, when and how.
std::string conditions_section(const ReportDocument& document);
/// How the errors are spread.
std::string histogram_section(const ReportDocument& document);
/// The errors as arrows at their places in the workspace, with a switch between before and after.
std::string cloud_section(const ReportDocument& document);
/// The errors of each set of points, point by point.
std::string point_sections(const ReportDocument& document);
/// What is left of the error along the motion of each joint, over the joint's position.
std::string joint_section(const ReportDocument& document);
/// What each layer of the model bought.
std::string layer_section(const ReportDocument& document);
/// How well unmeasured poses are known, with its heat maps.
std::string transfer_section(const ReportDocument& document);
std::string rejected_section(const ReportDocument& document);
/// How far a pose that was measured now and then moved meanwhile.
std::string drift_section(const ReportDocument& document);
std::string parameters_section(const ReportDocument& document);
/// What the data cannot tell, and how well the poses show the rest.
std::string unknown_section(const ReportDocument& document);
/// How the arm's stream of corrections went.
std::string stream_section(const ReportDocument& document);

// The sections of further documents.
std::string iso9283_section(const boost::json::object& document);
/// A tool or a base that was measured.
std::string frame_section(const boost::json::object& document);

// What sections have in common, and the report for a terminal with them. Plain text, not escaped.

/// A figure of the table of errors.
struct Figure {
  std::string_view axis, name;
  double (*of)(const ErrorStatistics&);
  double record::StageSpread::*spread = nullptr;  ///< over the runs of a validation
};
inline constexpr std::array kFigures{
    Figure{"3-D", "mean", [](const ErrorStatistics& s) { return s.mean; }, &record::StageSpread::mean},
    Figure{"3-D", "max", [](const ErrorStatistics& s) { return s.max; }, &record::StageSpread::max},
    Figure{"3-D", "min", [](const ErrorStatistics& s) { return s.min; }},
    Figure{"3-D", "RMS", [](const ErrorStatistics& s) { return s.rms; }, &record::StageSpread::rms},
    Figure{"3-D", "std", [](const ErrorStatistics& s) { return s.std; }},
    Figure{"x", "mean |x|", [](const ErrorStatistics& s) { return s.x.mean_abs; }},
    Figure{"x", "max |x|", [](const ErrorStatistics& s) { return s.x.max_abs; }},
    Figure{"y", "mean |y|", [](const ErrorStatistics& s) { return s.y.mean_abs; }},
    Figure{"y", "max |y|", [](const ErrorStatistics& s) { return s.y.max_abs; }},
    Figure{"z", "mean |z|", [](const ErrorStatistics& s) { return s.z.mean_abs; }},
    Figure{"z", "max |z|", [](const ErrorStatistics& s) { return s.z.max_abs; }},
};

/// A stage of the model and what it left of one set of points.
struct Stage {
  std::string_view name, color;
  const ErrorStatistics* errors;
  const record::StageSpread* spread = nullptr;  ///< over the runs of the validation, where there were several
};
/// The stages that the document tells apart, from before the calibration on.
std::vector<Stage> stages_of(const ReportDocument& document, PoseSet set);

/// Whether the model may be used, and what to do.
struct Verdict {
  enum class Kind { Use, Caution, Refuse } kind = Kind::Refuse;
  std::string sentence;
};
Verdict verdict_of(const ReportDocument& document);
/// What to do with the model by its verdict's color, without a full stop.
std::string verdict_heading(const ReportDocument& document);
/// Whether the correction did for a production program what it should.
Verdict production_verdict(const record::Production& production);
/// HTML.
std::string verdict_paragraph(const Verdict& verdict);

/// "14 times more accurate" or "no improvement".
std::string improvement_text(const ReportDocument& document);
/// "joint 2, harmonic 1" of "joint2.harmonic1".
std::string group_text(std::string_view name);
/// How the validation came about, for after its counts: "mean ± standard deviation over 10 splits". Empty
/// where it was one run.
std::string validation_text(const ReportDocument& document);
/// For what share of the link parameters a prior speaks. Empty where none was used.
std::string prior_text(const ReportDocument& document);
std::string transfer_text(const record::Transfer& transfer);
/// "30 poses, mean error 10.577 mm -> 0.030 mm; validation 12 poses, ...".
std::string station_text(const record::Station& station);
/// "station door.csv, pose 12, reflector 1, row 34", of which what is not known is left out.
std::string place_text(const record::Rejected& point);
/// How far such a point is off: "0.21 mm", "turned by 1.2 deg".
std::string distance_text(const record::Rejected& point);
/// "mean 0.3 -> 0.01 deg, ..": orientation errors of 6-D targets under the nominal and the calibrated arm.
std::string turns_text(const TurnErrors& turns);
/// How a 6-D target is mounted on the flange.
std::string mounting_text(const record::MountedTarget& target);
/// "2026-11-21 21:34 UTC" of "2026-11-21T21:34:43.239Z"; any other text as it is.
std::string time_text(const std::string& rfc3339);

/// The points of a calibration document as a measurement file, from which `truepose calibrate` with the
/// document's arm comes to the same result; empty where an older document does not say where they were.
std::string measurements_csv(const std::vector<record::Point>& points);
/// Title and content of the section of a production program.
std::string production_section(const record::Production& production);
/// The samples of a production program, mm in the robot's base frame.
std::string production_csv(const ProductionPath& path);
/// A text as a field of such files.
std::string csv_text(std::string_view text);

/// A smooth curve through scattered points (x, y), sampled at `samples` places (at least two) from the
/// smallest to the greatest x: at each a straight line fitted with Gaussian weights, single points far off
/// disregarded.
///
/// @param bandwidth  standard deviation of the weights, in units of x; above 0
/// @return empty for fewer than five points or where all have the same x
/// Source: Cleveland, Robust locally weighted regression, JASA 74 (1979), with a Gaussian for its tricube.
std::vector<std::pair<double, double>> local_regression(const std::vector<std::pair<double, double>>& points,
                                                        double bandwidth, int samples);

}  // namespace truepose::report
