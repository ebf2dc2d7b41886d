#pragma once

#include <chrono>

#include "tools/truepose/doctor/observations.hpp"
#include "tools/truepose/online/daemon_connection.hpp"

namespace truepose::tools {

/// How long is looked: the whole takes little more, since ports and devices are looked at at the same time.
inline constexpr std::chrono::milliseconds kListenTime{1500};

/// @param cell  whose daemon it must be
DaemonObservation observe_daemon(const std::string& cell, const DaemonAddress& address);

/// Listens to the RSI port, answers nothing.
/// @param daemon_has_port  then only what passes by is looked at
RsiObservation observe_rsi(const config::StreamConfig& stream, bool daemon_has_port);

std::vector<Interface> observe_interfaces();
MachineObservation observe_machine(const config::CellConfig& cell);

/// All of them.
/// @param address  its daemon empty: the control socket of the cell's runtime folder, else control.listen;
/// its
///                 token file empty: the cell's
Observations observe(const config::CellConfig& cell, DaemonAddress address);

}  // namespace truepose::tools
