#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "proto/record/layout.hpp"

namespace truepose::config {

/// How the simulated cell misbehaves at one time of its life, or again and again.
struct ScenarioFault {
  enum class Kind {
    BeamBreak,
    TrackerRestart,
    TrackerBump,    ///< the tracker is pushed: everything it sees is moved by `by_mm` from then on
    TrackerBias,    ///< what it measures is off by `by_mm`
    TrackerNoise,   ///< scatters by `sigma_mm` more, which its own standard deviations show
    TrackerStd,     ///< reports `std_mm`, whatever its standard deviations are
    TrackerStray,   ///< its search finds another reflector, `by_mm` from ours
    TrackerAir,     ///< reports this weather
    TrackerBusy,    ///< answers every command that it is busy
    TrackerSilent,  ///< takes commands, and answers none
    TrackerStorm,   ///< reports changes of its state without end
    EkiDrop,
    ProgramStop,        ///< STOP at the pendant; started again after `lasts`
    ProgramReset,       ///< cancelled and started from its first line
    ProgramSelect,      ///< `program` is selected and started in place of the one that was
    EmergencyStop,      ///< pressed; released, and the program started again, after `lasts`
    GateOpen,           ///< operator safety; closed, and the program started again, after `lasts`
    OperatingMode,      ///< the key turned to `mode`, and back after `lasts`
    Override,           ///< $OV_PRO set to `percent`, and back after `lasts`
    ControllerRestart,  ///< switched off, and on after `lasts`
    RsiDrop,            ///< no datagram gets through, either way
    RsiLoseDatagrams,   ///< none from the controller
    RsiLoseReplies,     ///< none to it
    RsiDuplicate,       ///< the controller's datagrams come twice
    RsiLate,            ///< each datagram of the controller comes a cycle late
    RsiCorrupt,         ///< a byte of each is another one
    RsiReorder,         ///< of two datagrams the later one comes first
    RsiSilence,         ///< the controller sends nothing, keeps what is in effect, and its clock continues
    RsiRestart,         ///< RSI is off, and then on with nothing in effect, from another port
    RsiIpoc,            ///< the time stamp jumps by `ipoc_by`
    RsiIgnore,          ///< replies are taken and move nothing
    RsiSecondSender,    ///< a controller of the same kind sends to the same port of the PC
  };
  /// What `at`, `lasts` and `every` count: ms of scaled time since the start, the RSI controller's cycles and
  /// the tracker's points of the simulator's life, both from 1.
  enum class Unit { Milliseconds, Cycles, Points };

  Kind kind = Kind::BeamBreak;
  Unit unit = Unit::Milliseconds;
  std::int64_t at = 0;
  std::int64_t lasts = 0;  ///< 0 = to the end, where it is not a matter of a moment
  std::int64_t every = 0;  ///< and again after so many; 0 = once

  Eigen::Vector3d by_mm{0, 0, 0};
  double sigma_mm = 0;
  double std_mm = 0;
  double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;
  std::int64_t ipoc_by = 0;           ///< RsiIpoc; RsiSecondSender: its clock is ahead by so many ms, 0 = far
  std::optional<std::uint64_t> ipoc;  ///< RsiRestart: its first time stamp; else the clock has gone on
  std::string from;                   ///< RsiSecondSender: its numeric address; empty = as the first's
  std::string program;                ///< ProgramSelect
  int percent = 100;                  ///< Override
  enum class Mode { T1 = 1, T2, Aut, Ext } mode = Mode::Ext;  ///< OperatingMode

  bool begins_with(std::int64_t count) const {
    return count == at || (every > 0 && count > at && (count - at) % every == 0);
  }
  bool covers(std::int64_t count) const {
    if (count < at) return false;
    return lasts == 0 || (every > 0 ? (count - at) % every : count - at) < lasts;
  }
};

void layout(record::Io& io, ScenarioFault& x);
void check(const record::Io& io, const ScenarioFault& x);

/// What a tracker reports: a broken sensor says anything.
inline constexpr record::Range kReported{-1e12, 1e12};

/// Reads one fault, a map of YAML or JSON on one line, that begins now. Throws ConfigError.
ScenarioFault parse_fault(const std::string& text);

}  // namespace truepose::config
