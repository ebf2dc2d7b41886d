#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "drivers/clock.hpp"
#include "drivers/net/network.hpp"
#include "tools/sim/controller/rsi_runner.hpp"

namespace truepose::sim {

/// What a simulated cell runs on: the PC, or a test's world. It outlives the cell.
struct Machine {
  boost::asio::any_io_executor io;  ///< one thread's
  drivers::Clock& clock;
  net::Network network{};
  StartRsi start_rsi = start_rsi_runner;
};

}  // namespace truepose::sim
