#pragma once

#include <string>

#include "config/scenario.hpp"
#include "tools/sim/simulated_cell.hpp"

namespace truepose::sim {

/// The injected truth, mm and rad: {"base": {x,y,z,rx,ry,rz}, "smr": {x,y,z}, "links":
/// [{a,alpha,d,theta,beta}...]}.
std::string truth_json(const config::Scenario& scenario);

/// What the cell did, with the truth: {"rsi": {...}, "moves", "measurements", "truth": {...}}.
std::string statistics_json(const CellStatistics& statistics, const config::Scenario& scenario);

}  // namespace truepose::sim
