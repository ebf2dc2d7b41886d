#include "config/scenario_fault.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "config/yaml_poses.hpp"

namespace truepose::config {

namespace {

using Fault = ScenarioFault;
using Kind = Fault::Kind;
using Unit = Fault::Unit;

constexpr std::int64_t kLongestTime = std::int64_t{1'000} * 31'536'000;  // a year in ms

/// The keys that say when, in each of the units.
struct When {
  Unit unit;
  std::string_view at, lasts, every;
};
constexpr std::array kWhens{When{Unit::Milliseconds, "at_ms", "lasts_ms", "every_ms"},
                            When{Unit::Cycles, "at_cycle", "lasts_cycles", "every_cycles"},
                            When{Unit::Points, "at_point", "lasts_points", "every_points"}};

bool counts_cycles(Kind kind) { return kind >= Kind::RsiDrop; }
bool counts_points(Kind kind) { return kind >= Kind::TrackerBump && kind <= Kind::TrackerAir; }

bool can_count(Kind kind, Unit unit) {
  if (unit == Unit::Cycles) return counts_cycles(kind);
  return unit == Unit::Milliseconds || counts_points(kind);
}

std::vector<std::string_view> values_of(Kind kind) {
  switch (kind) {
    case Kind::TrackerBump:
    case Kind::TrackerBias:
      return {"by_mm"};
    case Kind::TrackerNoise:
      return {"sigma_mm"};
    case Kind::TrackerStd:
      return {"std_mm"};
    case Kind::TrackerAir:
      return {"temperature_c", "pressure_mbar", "humidity_percent"};
    case Kind::RsiIpoc:
      return {"ipoc_by"};
    case Kind::RsiRestart:
      return {"ipoc"};
    case Kind::RsiSecondSender:
      return {"from"};
    default:
      return {};
  }
}

const When& when_of(const YamlMap& map) {
  const When* found = nullptr;
  for (const When& when : kWhens) {
    if (!map.has(when.at)) continue;
    if (found) map.at(when.at).fail("expected one of at_ms, at_cycle, at_point, and there is another");
    found = &when;
  }
  if (!found) map.value().fail("missing key 'at_ms', 'at_cycle' or 'at_point'");
  return *found;
}

void read_when(const YamlMap& map, Fault& fault) {
  const When& when = when_of(map);
  if (!can_count(fault.kind, when.unit)) map.at(when.at).fail("this kind of fault cannot be counted so");
  for (const When& other : kWhens) {
    for (const std::string_view key : {other.lasts, other.every}) {
      if (map.has(key) && &other != &when) map.at(key).fail("does not go with " + std::string{when.at});
    }
  }
  fault.unit = when.unit;
  fault.at = map.at(when.at).integer(when.unit == Unit::Milliseconds ? 0 : 1, kLongestTime);
  if (const YamlValue* lasts = map.find(when.lasts)) fault.lasts = lasts->integer(0, kLongestTime);
  if (const YamlValue* every = map.find(when.every)) fault.every = every->integer(1, kLongestTime);
}

void read_values(const YamlMap& map, Fault& fault) {
  constexpr Range kAny{-1e12, 1e12};
  if (const YamlValue* by = map.find("by_mm")) fault.by_mm = point_value(*by);
  map.read("sigma_mm", fault.sigma_mm, {0, 1000});
  map.read("std_mm", fault.std_mm, kAny);
  map.read("temperature_c", fault.temperature_c, kAny);
  map.read("pressure_mbar", fault.pressure_mbar, kAny);
  map.read("humidity_percent", fault.humidity_percent, kAny);
  if (const YamlValue* by = map.find("ipoc_by")) fault.ipoc_by = by->integer(-kLongestTime, kLongestTime);
  if (const YamlValue* ipoc = map.find("ipoc")) fault.ipoc = ipoc->seed();
  map.read("from", fault.from);
}

}  // namespace

ScenarioFault fault_value(const YamlValue& value) {
  const YamlMap map(
      value, {"kind", "at_ms", "lasts_ms", "every_ms", "at_cycle", "lasts_cycles", "every_cycles", "at_point",
              "lasts_points", "every_points", "by_mm", "sigma_mm", "std_mm", "temperature_c", "pressure_mbar",
              "humidity_percent", "ipoc_by", "ipoc", "from"});
  Fault fault;
  map.at("kind");
  map.read("kind", fault.kind,
           {{"beam-break", Kind::BeamBreak},
            {"tracker-restart", Kind::TrackerRestart},
            {"tracker-bump", Kind::TrackerBump},
            {"tracker-bias", Kind::TrackerBias},
            {"tracker-noise", Kind::TrackerNoise},
            {"tracker-std", Kind::TrackerStd},
            {"tracker-air", Kind::TrackerAir},
            {"eki-drop", Kind::EkiDrop},
            {"rsi-drop", Kind::RsiDrop},
            {"rsi-lose-datagrams", Kind::RsiLoseDatagrams},
            {"rsi-lose-replies", Kind::RsiLoseReplies},
            {"rsi-duplicate", Kind::RsiDuplicate},
            {"rsi-reorder", Kind::RsiReorder},
            {"rsi-silence", Kind::RsiSilence},
            {"rsi-restart", Kind::RsiRestart},
            {"rsi-ipoc", Kind::RsiIpoc},
            {"rsi-ignore", Kind::RsiIgnore},
            {"rsi-second-sender", Kind::RsiSecondSender}});
  const std::vector<std::string_view> own = values_of(fault.kind);
  for (const std::string_view key : {"by_mm", "sigma_mm", "std_mm", "temperature_c", "pressure_mbar",
                                     "humidity_percent", "ipoc_by", "ipoc", "from"}) {
    if (map.has(key) && std::ranges::count(own, key) == 0)
      map.at(key).fail("does not belong to " + map.at("kind").text());
  }
  const bool needed =
      fault.kind != Kind::TrackerAir && fault.kind != Kind::RsiRestart && fault.kind != Kind::RsiSecondSender;
  if (needed && !own.empty()) map.at(own.front());
  read_when(map, fault);
  read_values(map, fault);
  return fault;
}

}  // namespace truepose::config
