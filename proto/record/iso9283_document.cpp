#include "proto/record/iso9283_document.hpp"

#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

/// "a", "b" and "c", all of them or none.
void layout_angles(Io& io, std::optional<Eigen::Vector3d>& abc_rad) {
  if (!io.has("a", abc_rad.has_value())) return;
  if (!abc_rad) abc_rad.emplace(0, 0, 0);  // it is read or described
  io("a", abc_rad->x());
  io("b", abc_rad->y());
  io("c", abc_rad->z());
}
void layout(Io& io, PoseAccuracy& x) {
  io("p", x.p_mm);
  layout_xyz(io, x.xyz_mm, kAny);
  layout_angles(io, x.abc_rad);
}
void layout(Io& io, PoseRepeatability& x) {
  io("l", x.l_mm);
  io("mean", x.mean_mm);
  io("std", x.std_mm);
  layout_angles(io, x.abc_rad);
}
void layout(Io& io, AccuracyVariation& x) {
  io("p", x.p_mm);
  layout_angles(io, x.abc_rad);
}

/// One part of a drift, a length under its own key and three angles: dAP and dRP.
struct DriftPart {
  std::string_view key;
  double& length_mm;
  std::optional<Eigen::Vector3d>& abc_rad;
};
void layout(Io& io, const DriftPart& x) {
  io(x.key, x.length_mm);
  layout_angles(io, x.abc_rad);
}
void layout(Io& io, Iso9283Document::Set& x) {
  io("point", x.point);
  io("direction", x.direction);
  io("time", x.time);
  io("cycles", x.cycles, kCount);
  io.about("Accuracy, mm; angles where they were measured, rad")("AP", x.characteristics.accuracy);
  io.about("Repeatability, mm and rad")("RP", x.characteristics.repeatability);
}
void layout(Io& io, Iso9283Document::Variation& x) {
  io("point", x.point);
  io("time", x.time);
  io("directions", x.directions);
  io.about("Multi-directional accuracy variation")("vAP", x.variation);
}
void layout(Io& io, Iso9283Document::Drift& x) {
  io("point", x.point);
  io("direction", x.direction);
  io("times", x.times);
  io("dAP", DriftPart{"p", x.drift.ap_p_mm, x.drift.ap_abc_rad});
  io("dRP", DriftPart{"l", x.drift.rp_l_mm, x.drift.rp_abc_rad});
  io("moved", x.drift.moved_mm);
}
void check(const Io& io, const Iso9283Document::Drift& x) {
  if (x.times.empty()) io.fail_at("times", "expected a list of series");
}
void layout(Io& io, Iso9283Document& x) {
  io("standard", x.standard);
  io("frame", x.frame, kIso9283Frames);
  io.about("The fewest of any pose")("cycles", x.cycles, kCount);
  io.about("As many as the standard asks for")("complete", x.complete);
  io.about("Commanded poses that no cycle came to; left out where there is none")
      .optional("missing", x.missing);
  io("sets", x.sets);
  io("variations", x.variations);
  io("drifts", x.drifts);
}

boost::json::object iso9283_document(const Iso9283Document& document) { return to_json(document); }

std::vector<std::string> poses_without_cycle(std::span<const TestPoint> points) {
  std::vector<std::string> names;
  for (const TestPoint& point : points)
    if (point.attained.empty()) names.push_back(point.name);
  return names;
}

Iso9283Document iso9283_of(const Iso9283Result& result, std::span<const TestPoint> points,
                           Iso9283Frame frame) {
  const std::vector<std::string> missing = poses_without_cycle(points);
  const int fewest = missing.empty() ? result.fewest_cycles : 0;
  Iso9283Document x{.frame = frame,
                    .cycles = fewest,
                    .complete = fewest >= kIso9283Cycles,
                    .missing = missing,
                    .sets = {},
                    .variations = {},
                    .drifts = {}};
  for (const CycleSet& set : result.sets)
    x.sets.push_back({points[set.point].name, set.direction, set.series, set.cycles, set.characteristics});
  for (const PointVariation& v : result.variations)
    x.variations.push_back({points[v.point].name, v.series, v.directions, v.variation});
  for (const PointDrift& d : result.drifts)
    x.drifts.push_back({points[d.point].name, d.direction, d.series, d.drift});
  return x;
}

boost::json::object iso9283_document(const Iso9283Result& result, std::span<const TestPoint> points,
                                     Iso9283Frame frame) {
  return to_json(iso9283_of(result, points, frame));
}

std::expected<Iso9283Document, std::string> read_iso9283_document(const boost::json::object& document) {
  return from_json<Iso9283Document>(document);
}

}  // namespace truepose::record
