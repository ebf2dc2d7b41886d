#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <expected>
#include <functional>
#include <memory>

#include "daemon/threads/worker.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "drivers/net/network.hpp"
#include "drivers/start_failure.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::daemon {

using StartRsiLink = std::function<std::expected<std::unique_ptr<drivers::RsiLink>, drivers::StartFailure>(
    const drivers::RsiLinkOptions&, drivers::RsiResponder&)>;

/// What a daemon runs on: the PC with its threads, or a test's world. It outlives the daemon.
struct Machine {
  boost::asio::any_io_executor io;  ///< one thread's
  drivers::Clock& clock;
  Worker& store_thread;
  Worker& compute_thread;
  Worker& recorder_thread;
  drivers::WallClock wall_clock;
  net::Network network{};
  RandomBytes random = kernel_random;  ///< of all ids and nonces
  StartRsiLink start_rsi_link = &drivers::RsiLink::start;
};

}  // namespace truepose::daemon
