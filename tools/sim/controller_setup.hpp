#pragma once

#include <map>
#include <string>

#include "config/scenario.hpp"
#include "proto/rsi/context.hpp"
#include "tools/sim/controller.hpp"

namespace truepose::sim {

/// The controller of a scenario with the files that it has loaded. Throws ConfigError where one cannot be
/// used.
ControllerSetup controller_setup(const config::Scenario& scenario);

/// The RSI context with what the scenario has in its place. Throws ConfigError.
rsi::Context rsi_context(const config::Scenario& scenario);

}  // namespace truepose::sim
