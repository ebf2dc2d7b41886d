// What a scenario has go wrong in the cell, and when.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <vector>

#include "tools/sim/simulated_cell.hpp"

namespace truepose::sim {

namespace {

using FaultKind = config::ScenarioFault::Kind;

bool is_of_rsi(const config::ScenarioFault& fault) { return fault.kind >= FaultKind::RsiDrop; }

}  // namespace

/// @param at  of scaled time, since the start
void SimulatedCell::schedule(const config::ScenarioFault& fault, std::chrono::milliseconds at) {
  alarms_.at(start_ + shortened(at), [this, fault, at] {
    misbehave(fault);
    if (fault.every > 0) schedule(fault, at + std::chrono::milliseconds{fault.every});
  });
}

void SimulatedCell::begin(config::ScenarioFault fault) {
  fault.at = std::chrono::floor<std::chrono::milliseconds>(now()).count();
  scenario_.faults.push_back(fault);
  misbehave(fault);
}

void SimulatedCell::misbehave(const config::ScenarioFault& fault) {
  const std::chrono::milliseconds lasts{fault.lasts};
  const auto shorter = std::chrono::ceil<std::chrono::milliseconds>(shortened(lasts));
  if (is_of_rsi(fault)) {
    if (rsi_) rsi_->disturb(in_cycles(fault));
  } else if (fault.kind == FaultKind::BeamBreak) {
    tracker_->beam_break(shorter);
  } else if (fault.kind == FaultKind::TrackerRestart) {
    tracker_->restart();
  } else if (fault.kind == FaultKind::EkiDrop) {
    eki_.drop(shorter);
  } else if (fault.kind > FaultKind::EkiDrop) {
    disturb_robot(fault);
  } else {
    disturb_tracker();
    if (fault.lasts != 0) alarms_.at(machine_.clock.now() + shorter, [this] { disturb_tracker(); });
  }
}

/// What people do at the pendant and around the cell, and undo after its time.
void SimulatedCell::disturb_robot(const config::ScenarioFault& fault) {
  using Act = OperatorAct::Kind;
  using Acts = std::vector<OperatorAct>;
  const auto now_and_later = [&](const Acts& now, const Acts& later) {
    pass_time();
    for (const OperatorAct& act : now) controller_.operate(act);
    follow();
    if (fault.lasts == 0) return;
    for (const OperatorAct& act : later) operate_later(std::chrono::milliseconds{fault.lasts}, act);
  };
  const OperatorAct start{.kind = Act::Start};
  switch (fault.kind) {
    case FaultKind::ProgramStop:
      return now_and_later({{.kind = Act::Stop}}, {start});
    case FaultKind::ProgramReset:
      return now_and_later({{.kind = Act::Reset}, start}, {});
    case FaultKind::ProgramSelect:
      return now_and_later({{.kind = Act::Select, .program = fault.program}, start}, {});
    case FaultKind::EmergencyStop:
      return now_and_later({{.kind = Act::EmergencyStop}}, {{.kind = Act::ReleaseEmergencyStop}, start});
    case FaultKind::GateOpen:
      return now_and_later({{.kind = Act::OpenGate}}, {{.kind = Act::CloseGate}, start});
    case FaultKind::OperatingMode:
      return now_and_later(
          {{.kind = Act::SetMode, .number = static_cast<int>(fault.mode)}},
          {{.kind = Act::SetMode, .number = static_cast<int>(config::ScenarioFault::Mode::Ext)}, start});
    case FaultKind::Override:
      return now_and_later({{.kind = Act::SetOverride, .number = fault.percent}},
                           {{.kind = Act::SetOverride, .number = controller_.sources().override_percent}});
    case FaultKind::ControllerRestart:
      return now_and_later({{.kind = Act::SwitchOff}}, {{.kind = Act::SwitchOn}});
    default:
      return;
  }
}

/// RSI keeps real time, so its ms are not scaled.
config::ScenarioFault SimulatedCell::in_cycles(config::ScenarioFault fault) const {
  const std::int64_t cycle_ms = scenario_.cycle.count();
  fault.unit = config::ScenarioFault::Unit::Cycles;
  fault.lasts = (fault.lasts + cycle_ms - 1) / cycle_ms;
  fault.every = 0;  // comes again by its timer
  return fault;
}

std::vector<config::ScenarioFault> SimulatedCell::rsi_faults() const {
  std::vector<config::ScenarioFault> faults;
  std::ranges::copy_if(scenario_.faults, std::back_inserter(faults), [](const config::ScenarioFault& fault) {
    return is_of_rsi(fault) && fault.unit == config::ScenarioFault::Unit::Cycles;
  });
  return faults;
}

void SimulatedCell::point_begins(std::uint64_t number) {
  point_ = number;
  disturb_tracker();
}

/// What the scenario says of the tracker at this time and this point, all together.
void SimulatedCell::disturb_tracker() {
  // A timer rings a rounding error before its time.
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(now()).count();
  TrackerDisturbance disturbance{.bias_mm = scenario_.bias_mm,
                                 .std_mm = scenario_.std_mm,
                                 .temperature_c = scenario_.air.temperature_c,
                                 .pressure_mbar = scenario_.air.pressure_mbar,
                                 .humidity_percent = scenario_.air.humidity_percent};
  double extra_variance = 0;
  for (const config::ScenarioFault& fault : scenario_.faults) {
    const bool by_point = fault.unit == config::ScenarioFault::Unit::Points;
    if (!fault.covers(by_point ? static_cast<std::int64_t>(point_) : ms)) continue;
    if (fault.kind == FaultKind::TrackerBump) disturbance.moved_mm += fault.by_mm;
    if (fault.kind == FaultKind::TrackerStray) disturbance.stray_mm = fault.by_mm;
    if (fault.kind == FaultKind::TrackerBias) disturbance.bias_mm += fault.by_mm;
    if (fault.kind == FaultKind::TrackerNoise) extra_variance += fault.sigma_mm * fault.sigma_mm;
    disturbance.busy |= fault.kind == FaultKind::TrackerBusy;
    disturbance.silent |= fault.kind == FaultKind::TrackerSilent;
    disturbance.storms |= fault.kind == FaultKind::TrackerStorm;
    if (fault.kind == FaultKind::TrackerStd) disturbance.std_mm = fault.std_mm;
    if (fault.kind != FaultKind::TrackerAir) continue;
    disturbance.temperature_c = fault.temperature_c;
    disturbance.pressure_mbar = fault.pressure_mbar;
    disturbance.humidity_percent = fault.humidity_percent;
  }
  extra_sigma_mm_ = std::sqrt(extra_variance);
  tracker_->disturb(disturbance);
}

}  // namespace truepose::sim
