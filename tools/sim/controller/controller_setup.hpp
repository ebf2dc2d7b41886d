#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "config/scenario.hpp"
#include "proto/rsi/context.hpp"
#include "tools/sim/controller/controller.hpp"

namespace truepose::sim {

/// The controller of a scenario with the files that it has loaded. Throws ConfigError where one cannot be
/// used.
ControllerSetup controller_setup(const config::Scenario& scenario);

/// RSI contexts by the names that RSI_CREATE takes.
using RsiContexts = std::map<std::string, rsi::Context, std::less<>>;

/// The contexts that programs name, with what the scenario has in their place. Throws ConfigError.
RsiContexts rsi_contexts(const config::Scenario& scenario, const std::vector<krl::Source>& programs);

}  // namespace truepose::sim
