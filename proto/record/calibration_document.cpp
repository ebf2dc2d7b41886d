#include "proto/record/calibration_document.hpp"

#include <cassert>
#include <cmath>

#include "core/calibrate/option_names.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

namespace json = boost::json;

/// A count, in the mean of several documents a number.
struct Rounded {
  void read(const JsonPlace& place, int& count) const {
    count = static_cast<int>(std::lround(place.number({0, 1e9})));
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

void layout(auto& io, Is<StatedNoise::Form> auto& x) {
  auto& tracker = x.noise.tracker;
  io.defaulted("range_mm", tracker.range_mm, kNotNegative);
  io.defaulted("transverse_mm_per_m", tracker.transverse_mm_per_m, kNotNegative);
  io.defaulted("repeatability_mm", x.noise.repeatability_mm, kNotNegative);
  io.optional("range_mm_per_m", Unless{0.0, tracker.range_mm_per_m}, kNotNegative);
  io.optional("transverse_mm", Unless{0.0, tracker.transverse_mm}, kNotNegative);
}
void layout(auto& io, Is<AxisStatistics> auto& x) {
  io("mean_abs", x.mean_abs);
  io("rms", x.rms);
  io("max", x.max_abs);
}
void layout(auto& io, Is<ErrorStatistics> auto& x) {
  io("mean", x.mean);
  io("rms", x.rms);
  io("max", x.max);
  io("min", x.min);
  io("std", x.std);
  io("x", x.x);
  io("y", x.y);
  io("z", x.z);
}
void layout(auto& io, Is<TurnStatistics> auto& x) {
  io("mean_rad", x.mean_rad, kNotNegative);
  io("rms_rad", x.rms_rad, kNotNegative);
  io("max_rad", x.max_rad, kNotNegative);
}
void layout(auto& io, Is<TurnErrors> auto& x) {
  io("readings", x.readings, Rounded{});
  io("before", x.before);
  io("after", x.after);
}
void layout(auto& io, Is<StageErrors> auto& x) {
  io("poses", x.poses, Rounded{});
  io("points", x.points, Rounded{});
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
  io.optional("orientation_errors", x.orientation_errors);
  io.on_read(x,
             [](auto& read) { read.before.count = read.geometric.count = read.after.count = read.points; });
}
void layout(auto& io, Is<Iterations> auto& x) {
  io("coarse", x.coarse, kCount);
  io("fine", x.fine, kCount);
}
void layout(auto& io, Is<DeviationGain> auto& x) {
  io("name", x.name);
  io("chosen", x.chosen);
  io("rms_mm", x.rms_mm);
}
void layout(auto& io, Is<DeviationChoice> auto& x) {
  io("geometric_rms_mm", x.geometric_rms_mm);
  io("rms_mm", x.rms_mm);
  io("scale", x.scale);
  io("groups", x.gains);
}
void layout(auto& io, Is<FieldChoice> auto& x) {
  io("chosen", x.chosen);
  io("without_rms_mm", x.rms_zero);
  io("rms_mm", x.tried.rms);
  io("standard_error_mm", x.tried.standard_error);
}
void layout(auto& io, Is<Thermal> auto& x) {
  io("chosen", x.chosen);
  io("without_rms_mm", x.without_rms_mm, kNotNegative);
  io("rms_mm", x.rms_mm, kNotNegative);
  io.defaulted("time_constant_s", x.time_constant_s, kNotNegative);
  io.defaulted("time_constant_poses", x.time_constant_poses, kNotNegative);
  io.defaulted("reference_c", x.reference_c);
  io.defaulted("zero_per_k", x.zero_per_k);
  io.defaulted("expansion_ppm_per_k", x.expansion_ppm_per_k);
}
void layout(auto& io, Is<Observability> auto& x) {
  io("o1", x.indices.o1);
  io("o2", x.indices.o2);
  io("o3", x.indices.o3);
  io("o4", x.indices.o4);
  io("o5", x.indices.o5);
  io("not_identifiable", x.not_identifiable);
  io("weakly_identifiable", x.weakly_identifiable);
}
void layout(auto& io, Is<UsedPrior> auto& x) {
  io("used", x.used);
  if (!io.has("length_mm", x.used)) return;
  io("length_mm", x.scale.length_mm);
  io("angle_rad", x.scale.angle_rad);
}
void layout(auto& io, Is<Sweep> auto& x) {
  io("joint", x.joint, kNumber);
  io("from", x.from);
  io("to", x.to);
  io("count", x.count, Whole{2});
}
void layout(auto& io, Is<UncertaintyMap> auto& x) {
  io("x", x.x);
  io("y", x.y);
  io("held", x.held);
  io("sigma_mm", x.sigma_mm);
}
void check(const auto& io, const UncertaintyMap& x) {
  if (x.sigma_mm.size() != static_cast<std::size_t>(x.y.count))
    io.at("sigma_mm").fail("expected a list for each y");
  for (const std::vector<double>& row : x.sigma_mm) {
    if (row.size() != static_cast<std::size_t>(x.x.count))
      io.at("sigma_mm").fail("expected a number for each x");
  }
  for (const Sweep& sweep : {x.x, x.y}) {
    if (static_cast<std::size_t>(sweep.joint) > x.held.size()) io.at("held").fail("expected every joint");
  }
}
void layout(auto& io, Is<Transfer> auto& x) {
  io("rms_mm", x.rms_mm);
  io("max_mm", x.max_mm);
  io("worst_joints", x.worst_joints);
  io.optional("warning", x.warning);
  io.defaulted("maps", x.maps);
}
void layout(auto& io, Is<Rejected> auto& x) {
  io.defaulted("point", x.point, kNumber);
  io("row", x.row, kCount);
  io.defaulted("pose", x.pose, kNumber);
  io.defaulted("smr", x.smr);
  io.optional("station", x.station);
  io("residual_mm", x.residual_mm);
  io("sigmas", x.sigmas);
  io.optional("orientation_error_rad", Unless{0.0, x.orientation_error_rad}, kNotNegative);
}
void layout(auto& io, Is<Station> auto& x) {
  io("name", x.name);
  io("base", x.base);
  io("identify", x.identify);
  io.optional("validate", x.validate);
}
void layout(auto& io, Is<TurnedTarget> auto& x) {
  io("a", x.a);
  io("b", x.b);
  io("c", x.c);
  io("sigma", x.sigma, kNotNegative);
}
void layout(auto& io, Is<MountedTarget> auto& x) {
  io("smr", x.smr);
  io("rx", x.rxyz_rad.x());
  io("ry", x.rxyz_rad.y());
  io("rz", x.rxyz_rad.z());
  io("sigma_rad", x.sigma_rad, kNotNegative);
}
void layout(auto& io, Is<Point> auto& x) {
  io("pose", x.pose, kNumber);
  io("set", x.set, kPoseSetNames);
  io("smr", x.smr);
  io.optional("station", x.station);
  io("joints", x.joints);
  io.optional("position", x.position);
  io.optional("sigma", x.sigma);
  io.optional("excess", x.excess);
  io.optional("orientation", x.orientation);
  io.optional("direction", x.direction, Whole{-1, 1});
  io.optional("payload", x.payload);
  io.optional("time", x.time);
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
}
void layout(auto& io, Is<StageSpread> auto& x) {
  io("mean", x.mean);
  io("max", x.max);
  io("rms", x.rms);
}
void layout(auto& io, Is<Spread> auto& x) {
  io("over", x.over, kRunNames);
  io("count", x.count, Whole{2});
  io("before", x.before);
  io("geometric", x.geometric);
  io("after", x.after);
}
void layout(auto& io, Is<Extent> auto& x) {
  io("min", x.min);
  io("max", x.max);
}
void layout(auto& io, Is<Conditions> auto& x) {
  io("started", x.started);
  io("ended", x.ended);
  io("poses_measured", x.poses_measured, kCount);
  io("poses_skipped", x.poses_skipped, kCount);
  io.optional("temperature_c", x.temperature_c);
  io.optional("pressure_mbar", x.pressure_mbar);
  io.optional("humidity_percent", x.humidity_percent);
}
void layout(auto& io, Is<Remeasured> auto& x) {
  io("pose", x.pose, kNumber);
  io("smr", x.smr);
  io("error", x.error);
}
void layout(auto& io, Is<Stream::Turnaround> auto& x) {
  io("p50", x.p50);
  io("p99", x.p99);
  io("p999", x.p999);
  io("max", x.max);
}
void layout(auto& io, Is<Stream> auto& x) {
  constexpr Whole kMany{0, std::numeric_limits<std::int64_t>::max()};
  io("cycles", x.cycles, kMany);
  io("answered", x.answered, kMany);
  io("late", x.late, kMany);
  io("wrong_ipoc", x.wrong_ipoc, kMany);
  io.defaulted("unconfirmed", x.unconfirmed, kMany);
  io.defaulted("sessions", x.sessions, kMany);
  io("max_step_deg", x.max_step_deg);
  io("turnaround_us", x.turnaround_us);
}
void layout(auto& io, Is<ErrorLengths> auto& x) {
  io("mean", x.mean, kNotNegative);
  io("p95", x.p95, kNotNegative);
  io("max", x.max, kNotNegative);
}
void layout(auto& io, Is<ErrorComparison> auto& x) {
  io("count", x.count, kNumber);
  io("with", x.with);
  io("without", x.without);
}
void layout(auto& io, Is<PathSample> auto& x) {
  io("time_s", x.time_s);
  io("point", x.at_point);
  io("gain_percent", x.gain_percent, Range{kAny.min, 100});
  io("wanted", x.wanted_mm);
  io("with", x.with_mm);
  io("without", x.without_mm);
  io.optional("lagged", x.lagged_mm);
}
void layout(auto& io, Is<AxisLag> auto& x) {
  io("dead_time_s", x.dead_time_s, kNotNegative);
  io("time_constant_s", x.time_constant_s, kNotNegative);
  io("identified", x.identified);
}
void layout(auto& io, Is<DriveLag> auto& x) {
  io("axes", x.axes);
  io("residual_deg", x.residual_rad, Degrees{}, kNotNegative);
}
void layout(auto& io, Is<Production> auto& x) {
  io("program", x.path.program);
  io.optional("points", x.accuracy.points);
  io("points_partly_corrected", x.accuracy.points_partly_corrected, kCount);
  io.optional("path", x.accuracy.path);
  io.optional("path_lagged", x.accuracy.path_lagged);
  io.optional("lag", x.path.lag);
  io("samples", x.path.samples);
}
void layout(auto& io, Is<CalibrationDocument> auto& x) {
  io("method", x.method, kMethods);
  io("converged", x.converged);
  io("iterations", x.iterations);
  io("elapsed_s", x.elapsed_s);
  io("identify", x.identify);
  io.optional("validate", x.validate);
  io("rank", x.rank, kCount);
  io.optional("rank_gap", x.rank_gap);
  io("condition", x.condition);
  io.optional("sigma0_mm", x.sigma0_mm);
  io.optional("non_geometric", x.non_geometric);
  io.optional("residual", x.field);
  io.optional("thermal", x.thermal);
  io.optional("observability", x.observability);
  io.optional("prior", x.prior);
  io.optional("prediction_uncertainty", x.prediction_uncertainty);
  io.defaulted("rejected", x.rejected);
  io.optional("validation_outliers", x.validation_outliers);
  io.optional("base", x.base);
  io.optional("stations", x.stations);
  io.defaulted("smr", x.smr, ReflectorsByName{}, Xyz{});
  io.optional("targets", x.targets);
  io("parameters", x.parameters);
  io.optional("arm", x.arm);
  io.defaulted("points", x.points);

  io.optional("verdict", x.verdict, ColoredVerdict{});
  io.optional("noise", x.noise, StatedNoise{});
  io.optional("spread", x.spread);
  io.optional("fold_points", x.fold_points);
  io.optional("robot", x.robot);
  io.optional("tracker", x.tracker);
  io.optional("campaign", x.campaign);
  io.optional("model", x.model);
  io.optional("date", x.date);
  io.optional("files", x.files);
  io.optional("options", x.options);
  io.optional("conditions", x.conditions);
  io.optional("skipped", x.skipped);
  io.optional("interruptions", x.interruptions);
  io.optional("reference_drift_mm", x.reference_drift_mm);
  io.optional("remeasured", x.remeasured);
  io.optional("remeasured_points", x.remeasured_points);
  io.optional("stream", x.stream);
  io.optional("production", x.production);
}

json::object statistics_json(const ErrorStatistics& statistics) { return to_json(statistics); }

json::object stages_json(const StageErrors& stages) { return to_json(stages); }

json::object verdict_json(const CalibrationVerdict& verdict) {
  return to_json(ColoredVerdict{}.form_of(verdict));
}

json::object noise_json(const MeasurementNoise& noise) { return to_json(StatedNoise::Form{noise}); }

json::object production_json(const ProductionPath& path) {
  return to_json(Production{path, path_accuracy(path.samples)});
}

std::expected<Production, std::string> read_production(const json::object& production) {
  return from_json<Production>(production);
}

json::object calibration_document(const CalibrationDocument& document) {
  json::object json = to_json(document);
  assert(is_finite(json));  // a calibration that got elsewhere must have failed before
  return json;
}

std::expected<CalibrationDocument, std::string> read_calibration_document(const json::object& document) {
  auto read = from_json<CalibrationDocument>(document);
  if (read && read->remeasured) {
    read->remeasured->count = read->validate ? read->validate->points : read->identify.points;
  }
  return read;
}

}  // namespace truepose::record
