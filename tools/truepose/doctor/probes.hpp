#pragma once

#include <chrono>
#include <filesystem>

#include "tools/truepose/doctor/observations.hpp"

namespace truepose::tools {

/// How long is looked: the whole takes little more, since ports and devices are looked at at the same time.
inline constexpr std::chrono::milliseconds kListenTime{1500}, kDeviceTime{2500};

/// @param cell    whose daemon it must be
/// @param daemon  as RpcClient::connect() takes it
DaemonObservation observe_daemon(const std::string& cell, const std::string& daemon,
                                 const std::filesystem::path& token_file);

/// Listens to the RSI port, answers nothing.
/// @param daemon_has_port  then only what passes by is looked at
RsiObservation observe_rsi(const config::StreamConfig& stream, bool daemon_has_port);

/// Asks the controller who and where it is; moves and releases nothing.
std::expected<RobotObservation, drivers::RobotError> observe_robot(const config::RobotConfig& robot);

/// Asks the tracker what it is; writes and moves nothing.
std::expected<drivers::TrackerIdentity, drivers::TrackerError> observe_tracker(
    const config::TrackerConfig& tracker);

std::vector<Interface> observe_interfaces();
MachineObservation observe_machine(const config::CellConfig& cell);

/// All of them.
/// @param daemon  empty: the control socket of the cell's runtime folder, else control.listen
Observations observe(const config::CellConfig& cell, const std::string& daemon,
                     const std::filesystem::path& token_file);

}  // namespace truepose::tools
