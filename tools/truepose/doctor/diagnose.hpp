#pragma once

#include "tools/truepose/doctor/finding.hpp"
#include "tools/truepose/doctor/observations.hpp"

namespace truepose::tools {

/// What the observations mean: faults first, then warnings, each in the order in which to look at it. What
/// may follow from a fault that is named is left out. Pure: no I/O and no clock.
/// @param file  of the cell, as messages name it
Findings diagnose(const std::string& file, const config::CellConfig& cell, const Observations& seen);

// ---- Its parts ----

Findings daemon_findings(const std::string& file, const DaemonObservation& daemon);
Findings stream_findings(const config::CellConfig& cell, const rpc::CellStatus& status);
Findings rsi_findings(const config::CellConfig& cell, const Observations& seen);
Findings robot_findings(const config::CellConfig& cell, const Observations& seen);
Findings tracker_findings(const config::CellConfig& cell, const Observations& seen);
Findings machine_findings(const config::CellConfig& cell, const Observations& seen);

/// A sentence of the daemon's as a finding: what is behind its last colon or semicolon is what to do.
/// @param code  of the fault that it is of; empty: the stream's
Finding from_sentence(std::string area, Level level, const std::string& sentence, std::string code = {});

}  // namespace truepose::tools
