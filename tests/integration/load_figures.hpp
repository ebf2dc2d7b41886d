#pragma once

#include <sys/types.h>

#include <boost/json/value.hpp>

#include "tests/integration/live_cell.hpp"

namespace truepose {

double resident_MB(pid_t process);

/// p99 of the wire's turnaround between two looks at the controller ("rsi" of what it counted).
double p99_us(const boost::json::value& before, const boost::json::value& after);

/// Runs something for a while. @return p99 of the wire meanwhile, as the controller sees it
template <typename Run>
double p99_while(const LiveCell& cell, Run run) {
  const boost::json::value before = cell.simulated().at("rsi");
  run();
  return p99_us(before, cell.simulated().at("rsi"));
}

}  // namespace truepose
