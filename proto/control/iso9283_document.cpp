#include "proto/control/iso9283_document.hpp"

#include <boost/json.hpp>

namespace truepose::control {
namespace {

namespace json = boost::json;

void add_angles(json::object& object, const std::optional<Eigen::Vector3d>& abc_rad) {
  if (!abc_rad) return;
  object["a"] = abc_rad->x();
  object["b"] = abc_rad->y();
  object["c"] = abc_rad->z();
}

json::object accuracy_json(const PoseAccuracy& accuracy) {
  const Eigen::Vector3d& v = accuracy.xyz_mm;
  json::object object{{"p", accuracy.p_mm}, {"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
  add_angles(object, accuracy.abc_rad);
  return object;
}

json::object repeatability_json(const PoseRepeatability& repeatability) {
  json::object object{
      {"l", repeatability.l_mm}, {"mean", repeatability.mean_mm}, {"std", repeatability.std_mm}};
  add_angles(object, repeatability.abc_rad);
  return object;
}

json::array texts(const std::vector<std::string>& all) { return json::array(all.begin(), all.end()); }

json::object variation_json(const PointVariation& v, const std::string& point) {
  json::object vap{{"p", v.variation.p_mm}};
  add_angles(vap, v.variation.abc_rad);
  return {{"point", point}, {"time", v.series}, {"directions", texts(v.directions)}, {"vAP", std::move(vap)}};
}

json::object drift_json(const PointDrift& d, const std::string& point) {
  json::object dap{{"p", d.drift.ap_p_mm}}, drp{{"l", d.drift.rp_l_mm}};
  add_angles(dap, d.drift.ap_abc_rad);
  add_angles(drp, d.drift.rp_abc_rad);
  return {{"point", point},        {"direction", d.direction}, {"times", texts(d.series)},
          {"dAP", std::move(dap)}, {"dRP", std::move(drp)},    {"moved", d.drift.moved_mm}};
}

}  // namespace

std::string_view name_of(Iso9283Frame frame) {
  switch (frame) {
    case Iso9283Frame::AsGiven:
      return "as given";
    case Iso9283Frame::Model:
      return "model";
    case Iso9283Frame::Fitted:
      return "fitted";
  }
  return {};
}

json::object iso9283_document(const Iso9283Result& result, std::span<const TestPoint> points,
                              Iso9283Frame frame) {
  json::array sets, variations, drifts;
  for (const CycleSet& set : result.sets) {
    sets.push_back(json::object{{"point", points[set.point].name},
                                {"direction", set.direction},
                                {"time", set.series},
                                {"cycles", set.cycles},
                                {"AP", accuracy_json(set.characteristics.accuracy)},
                                {"RP", repeatability_json(set.characteristics.repeatability)}});
  }
  for (const PointVariation& v : result.variations)
    variations.push_back(variation_json(v, points[v.point].name));
  for (const PointDrift& d : result.drifts) drifts.push_back(drift_json(d, points[d.point].name));
  return {{"standard", "ISO 9283:1998"},    {"frame", name_of(frame)},
          {"cycles", result.fewest_cycles}, {"complete", result.fewest_cycles >= kIso9283Cycles},
          {"sets", std::move(sets)},        {"variations", std::move(variations)},
          {"drifts", std::move(drifts)}};
}

}  // namespace truepose::control
