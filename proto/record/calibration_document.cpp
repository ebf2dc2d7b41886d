#include "proto/record/calibration_document.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/calibrate/option_names.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"
#include "proto/record/schema_io.hpp"

namespace truepose::record {

namespace json = boost::json;

/// A count, in the mean of several documents a number.
struct Rounded {
  int form_of(int count) const { return count; }
  void read(Io& io, int& count) const {
    double mean = 0;
    io.value(mean, Range{0, 1e9});
    count = static_cast<int>(std::lround(mean));
  }
};

/// Reflectors by name: {"1": {x, y, z}}.
struct ReflectorsByName {
  ByName<Eigen::Vector3d> form_of(const std::vector<Reflector>& reflectors) const {
    ByName<Eigen::Vector3d> form;
    for (const Reflector& reflector : reflectors) form.emplace_back(reflector.name, reflector.p_FS_mm);
    return form;
  }
  std::vector<Reflector> value_of(const ByName<Eigen::Vector3d>& form) const {
    std::vector<Reflector> reflectors;
    for (const auto& [name, p_FS_mm] : form) reflectors.push_back({name, p_FS_mm});
    return reflectors;
  }
};

/// Noise as documents have it: what is usual, and what is not where there is some.
struct StatedNoise {
  struct Form {
    MeasurementNoise noise;
  };
  Form form_of(const MeasurementNoise& noise) const { return {noise}; }
  MeasurementNoise value_of(const Form& form) const { return form.noise; }
};

// Layouts: the members of each record in the order of the document.

void layout(Io& io, StatedNoise::Form& x) {
  auto& tracker = x.noise.tracker;
  io.defaulted("range_mm", tracker.range_mm, kNotNegative);
  io.defaulted("transverse_mm_per_m", tracker.transverse_mm_per_m, kNotNegative);
  io.defaulted("repeatability_mm", x.noise.repeatability_mm, kNotNegative);
  io.optional("range_mm_per_m", Unless{0.0, tracker.range_mm_per_m}, kNotNegative);
  io.optional("transverse_mm", Unless{0.0, tracker.transverse_mm}, kNotNegative);
}
void layout(Io& io, AxisStatistics& x) {
  io.record("axis", "");
  io("mean_abs", x.mean_abs, kNotNegative);
  io("rms", x.rms, kNotNegative);
  io("max", x.max_abs, kNotNegative);
}
void layout(Io& io, ErrorStatistics& x) {
  io.record("statistics", "of the position error, mm");
  io("mean", x.mean, kNotNegative);
  io("rms", x.rms, kNotNegative);
  io("max", x.max, kNotNegative);
  io("min", x.min, kNotNegative);
  io("std", x.std, kNotNegative);
  io("x", x.x);
  io("y", x.y);
  io("z", x.z);
}
void layout(Io& io, TurnStatistics& x) {
  io.record("orientation_statistics", "");
  io("mean_rad", x.mean_rad, kNotNegative);
  io("rms_rad", x.rms_rad, kNotNegative);
  io("max_rad", x.max_rad, kNotNegative);
}
void layout(Io& io, TurnErrors& x) {
  io("readings", x.readings, Rounded{});
  io("before", x.before);
  io("after", x.after);
}
void layout(Io& io, StageErrors& x) {
  io.record(
      "stages",
      "before: nominal arm, base and reflectors fitted; geometric: after the fine stage; after: with all layers");
  io.about("a mean, not always whole, over splits")("poses", x.poses, Rounded{});
  io("points", x.points, Rounded{});
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
  io.about("how far 6-D targets are turned from where the nominal and the calibrated arm have them")
      .optional("orientation_errors", x.orientation_errors);
  io.on_read(x,
             [](auto& read) { read.before.count = read.geometric.count = read.after.count = read.points; });
}
void layout(Io& io, Iterations& x) {
  io.record("iterations", "");
  io("coarse", x.coarse, kCount);
  io("fine", x.fine, kCount);
}
void layout(Io& io, DeviationGain& x) {
  io("name", x.name);
  io("chosen", x.chosen);
  io("rms_mm", x.rms_mm, kNotNegative);
}
void layout(Io& io, DeviationChoice& x) {
  io("geometric_rms_mm", x.geometric_rms_mm, kNotNegative);
  io("rms_mm", x.rms_mm, kNotNegative);
  io("scale", x.scale, kNotNegative);
  io("groups", x.gains);
}
void layout(Io& io, FieldChoice& x) {
  io("chosen", x.chosen);
  io("without_rms_mm", x.rms_zero, kNotNegative);
  io("rms_mm", x.tried.rms, kNotNegative);
  io("standard_error_mm", x.tried.standard_error, kNotNegative);
}
void layout(Io& io, Thermal& x) {
  io("chosen", x.chosen);
  io("without_rms_mm", x.without_rms_mm, kNotNegative);
  io("rms_mm", x.rms_mm, kNotNegative);
  io.defaulted("time_constant_s", x.time_constant_s, kNotNegative);
  io.defaulted("time_constant_poses", x.time_constant_poses, kNotNegative);
  io.defaulted("reference_c", x.reference_c);
  io.defaulted("zero_per_k", x.zero_per_k);
  io.defaulted("expansion_ppm_per_k", x.expansion_ppm_per_k);
}
void layout(Io& io, Observability& x) {
  io("o1", x.indices.o1, kNotNegative);
  io("o2", x.indices.o2, kNotNegative);
  io("o3", x.indices.o3, kNotNegative);
  io("o4", x.indices.o4, kNotNegative);
  io("o5", x.indices.o5, kNotNegative);
  io("not_identifiable", x.not_identifiable);
  io("weakly_identifiable", x.weakly_identifiable);
}
void layout(Io& io, UsedPrior& x) {
  io("used", x.used);
  if (!io.has("length_mm", x.used)) return;
  io("length_mm", x.scale.length_mm, kNotNegative);
  io("angle_rad", x.scale.angle_rad, kNotNegative);
}
void layout(Io& io, Sweep& x) {
  io.record("sweep", "");
  io("joint", x.joint, kNumber);
  io("from", x.from);
  io("to", x.to);
  io("count", x.count, Whole{2});
}
void layout(Io& io, UncertaintyMap& x) {
  io.record("map", "");
  io("x", x.x);
  io("y", x.y);
  io("held", x.held);
  io("sigma_mm", x.sigma_mm, kNotNegative);
}
void check(const Io& io, const UncertaintyMap& x) {
  if (x.sigma_mm.size() != static_cast<std::size_t>(x.y.count))
    io.fail_at("sigma_mm", "expected a list for each y");
  for (const std::vector<double>& row : x.sigma_mm) {
    if (row.size() != static_cast<std::size_t>(x.x.count))
      io.fail_at("sigma_mm", "expected a number for each x");
  }
  for (const Sweep& sweep : {x.x, x.y}) {
    if (static_cast<std::size_t>(sweep.joint) > x.held.size()) io.fail_at("held", "expected every joint");
  }
}
void layout(Io& io, Transfer& x) {
  io("rms_mm", x.rms_mm, kNotNegative);
  io("max_mm", x.max_mm, kNotNegative);
  io.about("positions of all joints, deg (mm for a prismatic joint)")("worst_joints", x.worst_joints);
  io.optional("warning", x.warning);
  io.defaulted("maps", x.maps);
}
void layout(Io& io, Rejected& x) {
  io.record("far_point", "");
  io.defaulted("point", x.point, kNumber);
  io("row", x.row, kCount);
  io.defaulted("pose", x.pose, kNumber);
  io.defaulted("smr", x.smr);
  io.about("where there are several").optional("station", x.station);
  io("residual_mm", x.residual_mm, kNotNegative);
  io("sigmas", x.sigmas, kNotNegative);
  io.about("by which its target is turned off, where that contradicts the others")
      .optional("orientation_error_rad", Unless{0.0, x.orientation_error_rad}, kNotNegative);
}
void layout(Io& io, Station& x) {
  io("name", x.name);
  io.about("the robot's base in the station's tracker frame")("base", x.base);
  io("identify", x.identify);
  io.optional("validate", x.validate);
}
void layout(Io& io, TurnedTarget& x) {
  io("a", x.a);
  io("b", x.b);
  io("c", x.c);
  io("sigma", x.sigma, kNotNegative);
}
void layout(Io& io, MountedTarget& x) {
  io("smr", x.smr);
  io("rx", x.rxyz_rad.x());
  io("ry", x.rxyz_rad.y());
  io("rz", x.rxyz_rad.z());
  io("sigma_rad", x.sigma_rad, kNotNegative);
}
void layout(Io& io, Point& x) {
  io.record(
      "point",
      "one measurement; errors: predicted minus measured, mm, tracker frame (of several stations, the first one's)");
  io("pose", x.pose, kNumber);
  io("set", x.set, kPoseSetNames);
  io("smr", x.smr);
  io.about("where there are several").optional("station", x.station);
  io.about("positions of all joints, deg (mm for a prismatic joint)")("joints", x.joints);
  io.about("measured, mm, in the frame of the errors").defaulted("position", x.position);
  io.about("standard uncertainty per axis, mm").optional("sigma", x.sigma, kNotNegative);
  io.about("standard deviation per axis beyond that of the noise, where the tracker's readings scattered, mm")
      .optional("excess", x.excess, kNotNegative);
  io.about(
        "of a 6-D target: KUKA's A, B, C of its axes, deg, in the frame of the errors; sigma: of a turn about each axis")
      .optional("orientation", x.orientation);
  io.about("side from which each joint arrived").optional("direction", x.direction, Whole{-1, 1});
  io.optional("payload", x.payload);
  io.optional("time", x.time);
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
}
void layout(Io& io, StageSpread& x) {
  io.record("stage_spread", "standard deviations over the runs, mm");
  io("mean", x.mean, kNotNegative);
  io("max", x.max, kNotNegative);
  io("rms", x.rms, kNotNegative);
}
void layout(Io& io, Spread& x) {
  io("over", x.over, kRunNames);
  io("count", x.count, Whole{2});
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
}
void layout(Io& io, Extent& x) {
  io.record("range", "");
  io("min", x.min);
  io("max", x.max);
}
void layout(Io& io, Conditions& x) {
  io.format("date-time")("started", x.started);
  io.format("date-time")("ended", x.ended);
  io("poses_measured", x.poses_measured, kCount);
  io("poses_skipped", x.poses_skipped, kCount);
  io.optional("temperature_c", x.temperature_c);
  io.optional("pressure_mbar", x.pressure_mbar);
  io.optional("humidity_percent", x.humidity_percent);
}
void layout(Io& io, Remeasured& x) {
  io("pose", x.pose, kNumber);
  io("smr", x.smr);
  io.about("wanted minus measured, mm, tracker frame")("error", x.error);
}
void layout(Io& io, Stream::Turnaround& x) {
  io("p50", x.p50, kNotNegative);
  io("p99", x.p99, kNotNegative);
  io("p999", x.p999, kNotNegative);
  io("max", x.max, kNotNegative);
}
void layout(Io& io, Stream& x) {
  io.further_members();
  constexpr Whole kMany{0, std::numeric_limits<std::int64_t>::max()};
  io("cycles", x.cycles, kMany);
  io("answered", x.answered, kMany);
  io("late", x.late, kMany);
  io("wrong_ipoc", x.wrong_ipoc, kMany);
  io.defaulted("unconfirmed", x.unconfirmed, kMany);
  io.defaulted("sessions", x.sessions, kMany);
  io("max_step_deg", x.max_step_deg, kNotNegative);
  io("turnaround_us", x.turnaround_us);
}
void layout(Io& io, ErrorLengths& x) {
  io.record("lengths", "of errors, mm; p95: not exceeded by 95 % of them");
  io("mean", x.mean, kNotNegative);
  io("p95", x.p95, kNotNegative);
  io("max", x.max, kNotNegative);
}
void layout(Io& io, ErrorComparison& x) {
  io.record("comparison", "the same samples with the correction and without it");
  io("count", x.count, kNumber);
  io("with", x.with);
  io("without", x.without);
}
void layout(Io& io, PathSample& x) {
  io("time_s", x.time_s);
  io.about("whether the program stands at one of its points")("point", x.at_point);
  io.about("of the correction that was in effect; below 0: none, and why")("gain_percent", x.gain_percent,
                                                                           Range{kAny.min, 100});
  io.about("of the data sheet's arm at the set points")("wanted", x.wanted_mm);
  io.about("of the real arm as it went")("with", x.with_mm);
  io.about("of the real arm, had its axes stood at the set points")("without", x.without_mm);
  io.about("of the data sheet's arm at the set points with the lag of the drives applied")
      .optional("lagged", x.lagged_mm);
}
void layout(Io& io, AxisLag& x) {
  io("dead_time_s", x.dead_time_s, kNotNegative);
  io("time_constant_s", x.time_constant_s, kNotNegative);
  io.about("false: the axis moved too little, and the mean of the other axes stands here")("identified",
                                                                                           x.identified);
}
void layout(Io& io, DriveLag& x) {
  io("axes", x.axes);
  io.about("RMS of actual less lagged axis")("residual_deg", x.residual_rad, Degrees{}, kNotNegative);
}
void layout(Io& io, Production& x) {
  io("program", x.path.program);
  io.about("where the program stood and all of the correction was in effect")
      .optional("points", x.accuracy.points);
  io.about("not judged")("points_partly_corrected", x.accuracy.points_partly_corrected, kCount);
  io.about("distance from the wanted path, of all samples between the points with all of the correction")
      .optional("path", x.accuracy.path);
  io.about(
        "with the correction: distance of the same samples from the wanted path with the lag of the drives applied")
      .optional("path_lagged", x.accuracy.path_lagged);
  io.about("how the axes follow what they are given, where they were recorded").optional("lag", x.path.lag);
  io("samples", x.path.samples);
}
void layout(Io& io, ProductionDocument& x) {
  io("robot", x.robot);
  io("model", x.model);
  io("production", x.production);
}
void layout(Io& io, Run& x) {
  io.optional("seed", x.seed);
  io.optional("fold", x.fold, kNumber);
  io("converged", x.converged);
  io("iterations", x.iterations);
  io("identify", x.identify);
  io("validate", x.validate);
  io("rank", x.rank, kCount);
  io("condition", x.condition, kNotNegative);
}
void layout(Io& io, TrueLink& x) {
  io("a", x.a_mm);
  io("alpha", x.alpha_rad);
  io("d", x.d_mm);
  io("theta", x.theta_rad);
  io("beta", x.beta_rad);
}
void layout(Io& io, Truth& x) {
  io("base", x.base);
  io("smr", x.p_FS_mm, Xyz{});
  io("links", x.links);
}
void layout(Io& io, CalibrationDocument& x) {
  io.record(
      "",
      "What truepose calibrate --json prints, the daemon keeps of a campaign and truepose report reads. mm and rad unless a name or description says otherwise. One that an earlier version made may lack what that did not know.");
  io("method", x.method, kMethods);
  io("converged", x.converged);
  io("iterations", x.iterations);
  io("elapsed_s", x.elapsed_s, kNotNegative);
  io("identify", x.identify);
  io.optional("validate", x.validate);
  io("rank", x.rank, kCount);
  io.optional("rank_gap", x.rank_gap, kNotNegative);
  io("condition", x.condition, kNotNegative);
  io.defaulted("sigma0_mm", x.sigma0_mm, kNotNegative);
  io.optional("non_geometric", x.non_geometric);
  io.optional("residual", x.field);
  io.about("thermal expansion of the arm; all else holds at the reference temperatures")
      .optional("thermal", x.thermal);
  io.defaulted("observability", x.observability);
  io.defaulted("prior", x.prior);
  io.optional("prediction_uncertainty", x.prediction_uncertainty);
  io.about("points to identify that were left out").defaulted("rejected", x.rejected);
  io.about("validation points beyond six sigma, in the statistics all the same")
      .optional("validation_outliers", x.validation_outliers);
  io.about("X_WB, the robot's base in the tracker frame (of several stations, the first one's)")
      .defaulted("base", x.base);
  io.about("where the tracker measured from several").optional("stations", x.stations);
  io.about("p_FS of each reflector by its name, mm, flange frame")
      .defaulted("smr", x.smr, ReflectorsByName{}, Xyz{});
  io.about("how each reflector that is a 6-D target is mounted on the flange: R_FT = Rz(rz) Ry(ry) Rx(rx)")
      .optional("targets", x.targets);
  io("parameters", x.parameters);
  io.about("the nominal one, as in a robot file").defaulted("arm", x.arm);
  io.defaulted("points", x.points);

  io.about("whether the model may be trusted, the gravest finding first")
      .optional("verdict", x.verdict, ColoredVerdict{});
  io.optional("noise", x.noise, StatedNoise{});
  io.about("of a validation in several runs").optional("spread", x.spread);
  io.optional("splits", x.splits);
  io.about("every point as the fit predicts it that had not seen its pose")
      .optional("fold_points", x.fold_points);
  io.optional("robot", x.robot);
  io.optional("tracker", x.tracker);
  io.optional("campaign", x.campaign);
  io.optional("model", x.model);
  io.format("date-time").optional("date", x.date);
  io.about("what was read, by what it is").optional("files", x.files);
  io.about("how files were understood that were not in truepose's own form, a sentence each")
      .optional("read_as", x.read_as);
  io.about("how it was identified").optional("options", x.options);
  io.optional("conditions", x.conditions);
  io.about("after which the campaign resumed").optional("interruptions", x.interruptions);
  io.optional("reference_drift_mm", x.reference_drift_mm, kNotNegative);
  io.about("validation poses reached with compensated joints").optional("remeasured", x.remeasured);
  io.optional("remeasured_points", x.remeasured_points);
  io.optional("skipped", x.skipped);
  io.about("further members of stream.status").optional("stream", x.stream);
  io.about(
        "how a production program went under correction: where the reflector was, mm, the robot's base frame")
      .optional("production", x.production);
  io.about("what a simulated arm really is").optional("truth", x.truth);
}

json::object verdict_json(const CalibrationVerdict& verdict) {
  return to_json(ColoredVerdict{}.form_of(verdict));
}

Production production_of(ProductionPath path) {
  PathAccuracy accuracy = path_accuracy(path.samples);
  return {std::move(path), std::move(accuracy)};
}

json::object calibration_document(const CalibrationDocument& document) {
  json::object json = to_json(document);
  assert(is_finite(json));  // a calibration that got elsewhere must have failed before
  return json;
}

namespace {

/// The mean of every number over records of the same shape (objects of numbers and such objects).
json::value mean_of(const json::array& records) {
  if (records[0].is_object()) {
    json::object mean;
    for (const auto& member : records[0].get_object()) {
      json::array values;
      for (const json::value& record : records) values.push_back(record.at(member.key()));
      mean[member.key()] = mean_of(values);
    }
    return mean;
  }
  double sum = 0;
  for (const json::value& number : records) sum += number.to_number<double>();
  // A count that is the same everywhere stays a whole number.
  const bool all_equal = std::ranges::count(records, records[0]) == std::ssize(records);
  return all_equal ? records[0] : json::value(sum / static_cast<double>(records.size()));
}

}  // namespace

json::object calibration_document_over_splits(const CalibrationDocument& document) {
  std::vector<StageErrors> validations;
  for (const Run& run : document.splits) validations.push_back(run.validate);
  json::object json = calibration_document(document);
  json["validate"] = mean_of(to_json(validations));
  return json;
}

json::object calibration_document_schema() {
  json::object schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"title", "truepose calibration document"}};
  for (auto& [key, value] : schema_of<CalibrationDocument>()) schema[key] = std::move(value);
  return schema;
}

std::expected<CalibrationDocument, std::string> read_calibration_document(const json::object& document) {
  auto read = from_json<CalibrationDocument>(document);
  if (read && read->remeasured) {
    read->remeasured->count = read->validate ? read->validate->points : read->identify.points;
  }
  return read;
}

}  // namespace truepose::record
