#include "config/scenario_fault.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "config/yaml_layout.hpp"

namespace truepose::config {

using Fault = ScenarioFault;
using FaultKind = Fault::Kind;
using FaultUnit = Fault::Unit;

constexpr std::array kFaults{Named{"beam-break", FaultKind::BeamBreak},
                             Named{"tracker-restart", FaultKind::TrackerRestart},
                             Named{"tracker-bump", FaultKind::TrackerBump},
                             Named{"tracker-bias", FaultKind::TrackerBias},
                             Named{"tracker-noise", FaultKind::TrackerNoise},
                             Named{"tracker-std", FaultKind::TrackerStd},
                             Named{"tracker-stray", FaultKind::TrackerStray},
                             Named{"tracker-air", FaultKind::TrackerAir},
                             Named{"tracker-busy", FaultKind::TrackerBusy},
                             Named{"tracker-silent", FaultKind::TrackerSilent},
                             Named{"tracker-storm", FaultKind::TrackerStorm},
                             Named{"eki-drop", FaultKind::EkiDrop},
                             Named{"program-stop", FaultKind::ProgramStop},
                             Named{"program-reset", FaultKind::ProgramReset},
                             Named{"program-select", FaultKind::ProgramSelect},
                             Named{"emergency-stop", FaultKind::EmergencyStop},
                             Named{"gate-open", FaultKind::GateOpen},
                             Named{"operating-mode", FaultKind::OperatingMode},
                             Named{"override", FaultKind::Override},
                             Named{"controller-restart", FaultKind::ControllerRestart},
                             Named{"rsi-drop", FaultKind::RsiDrop},
                             Named{"rsi-lose-datagrams", FaultKind::RsiLoseDatagrams},
                             Named{"rsi-lose-replies", FaultKind::RsiLoseReplies},
                             Named{"rsi-duplicate", FaultKind::RsiDuplicate},
                             Named{"rsi-late", FaultKind::RsiLate},
                             Named{"rsi-corrupt", FaultKind::RsiCorrupt},
                             Named{"rsi-reorder", FaultKind::RsiReorder},
                             Named{"rsi-silence", FaultKind::RsiSilence},
                             Named{"rsi-restart", FaultKind::RsiRestart},
                             Named{"rsi-ipoc", FaultKind::RsiIpoc},
                             Named{"rsi-ignore", FaultKind::RsiIgnore},
                             Named{"rsi-second-sender", FaultKind::RsiSecondSender}};

constexpr std::array kModes{Named{"T1", Fault::Mode::T1}, Named{"T2", Fault::Mode::T2},
                            Named{"AUT", Fault::Mode::Aut}, Named{"EXT", Fault::Mode::Ext}};

constexpr std::int64_t kLongestTime = std::int64_t{1'000} * 31'536'000;  // a year in ms

/// The keys that say when, in each of the units.
struct When {
  FaultUnit unit;
  std::string_view at, lasts, every;
};
constexpr std::array kWhens{When{FaultUnit::Milliseconds, "at_ms", "lasts_ms", "every_ms"},
                            When{FaultUnit::Cycles, "at_cycle", "lasts_cycles", "every_cycles"},
                            When{FaultUnit::Points, "at_point", "lasts_points", "every_points"}};

bool counts_cycles(FaultKind kind) { return kind >= FaultKind::RsiDrop; }
bool counts_points(FaultKind kind) { return kind >= FaultKind::TrackerBump && kind <= FaultKind::TrackerAir; }

bool can_count(FaultKind kind, FaultUnit unit) {
  if (unit == FaultUnit::Cycles) return counts_cycles(kind);
  return unit == FaultUnit::Milliseconds || counts_points(kind);
}

std::vector<std::string_view> values_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::TrackerBump:
    case FaultKind::TrackerBias:
    case FaultKind::TrackerStray:
      return {"by_mm"};
    case FaultKind::TrackerNoise:
      return {"sigma_mm"};
    case FaultKind::TrackerStd:
      return {"std_mm"};
    case FaultKind::TrackerAir:
      return {"temperature_c", "pressure_mbar", "humidity_percent"};
    case FaultKind::RsiIpoc:
      return {"ipoc_by"};
    case FaultKind::RsiRestart:
      return {"ipoc"};
    case FaultKind::RsiSecondSender:
      return {"from", "ipoc_by"};
    case FaultKind::ProgramSelect:
      return {"program"};
    case FaultKind::OperatingMode:
      return {"mode"};
    case FaultKind::Override:
      return {"percent"};
    default:
      return {};
  }
}

void layout(Io& io, Fault& x) {
  constexpr Whole kMoment{0, kLongestTime}, kPeriod{1, kLongestTime};
  io("kind", x.kind, kFaults);
  for (const When& when : kWhens) {
    if (io.has(when.at, false)) x.unit = when.unit;
    io.optional(when.at, x.at, when.unit == FaultUnit::Milliseconds ? kMoment : kPeriod);
    io.optional(when.lasts, x.lasts, kMoment);
    io.optional(when.every, x.every, kPeriod);
  }
  io.optional("by_mm", x.by_mm, kPoint);
  io.optional("sigma_mm", x.sigma_mm, Range{0, 1000});
  io.optional("std_mm", x.std_mm, kReported);
  io.optional("temperature_c", x.temperature_c, kReported);
  io.optional("pressure_mbar", x.pressure_mbar, kReported);
  io.optional("humidity_percent", x.humidity_percent, kReported);
  io.optional("ipoc_by", x.ipoc_by, Whole{-kLongestTime, kLongestTime});
  io.optional("ipoc", x.ipoc);
  io.optional("from", x.from);
  io.optional("program", x.program);
  io.optional("mode", x.mode, kModes);
  io.optional("percent", x.percent, Whole{0, 100});
}

/// That it says when, in one unit, which its kind can count.
void check_when(const Io& io, const Fault& fault) {
  const When* found = nullptr;
  for (const When& when : kWhens) {
    if (!io.has(when.at, false)) continue;
    if (found) io.fail_at(when.at, "expected one of at_ms, at_cycle, at_point, and there is another");
    found = &when;
  }
  if (!found) io.fail("missing key 'at_ms', 'at_cycle' or 'at_point'");
  if (!can_count(fault.kind, found->unit)) io.fail_at(found->at, "this kind of fault cannot be counted so");
  for (const When& other : kWhens) {
    for (const std::string_view key : {other.lasts, other.every}) {
      if (io.has(key, false) && &other != found)
        io.fail_at(key, "does not go with " + std::string{found->at});
    }
  }
}

/// That it has what belongs to its kind, and nothing else.
void check_values(const Io& io, const Fault& fault) {
  const std::vector<std::string_view> own = values_of(fault.kind);
  for (const std::string_view key :
       {"by_mm", "sigma_mm", "std_mm", "temperature_c", "pressure_mbar", "humidity_percent", "ipoc_by",
        "ipoc", "from", "program", "mode", "percent"}) {
    if (io.has(key, false) && std::ranges::count(own, key) == 0)
      io.fail_at(key, "does not belong to " + std::string{name_of(kFaults, fault.kind)});
  }
  const bool needed = fault.kind != FaultKind::TrackerAir && fault.kind != FaultKind::RsiRestart &&
                      fault.kind != FaultKind::RsiSecondSender;
  if (needed && !own.empty()) io.require(own.front());
}

void check(const Io& io, const Fault& fault) {
  check_values(io, fault);
  check_when(io, fault);
}

/// A fault that begins when it is read.
struct Immediate {
  Fault fault;
};

void layout(Io& io, Immediate& x) { layout(io, x.fault); }

void check(const Io& io, const Immediate& x) {
  check_values(io, x.fault);
  for (const When& when : kWhens) {
    for (const std::string_view key : {when.at, when.every}) {
      if (io.has(key, false)) io.fail_at(key, "it begins now, once; leave this out");
    }
  }
}

ScenarioFault parse_fault(const std::string& text) {
  Immediate immediate;
  read_value(parse_yaml(text, "fault"), immediate);
  return immediate.fault;
}

}  // namespace truepose::config
