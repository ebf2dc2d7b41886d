#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "config/cell_config.hpp"
#include "drivers/net/stream.hpp"
#include "drivers/timed_tracker.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::daemon {

/// The driver for a cell's tracker.
/// @param clock  outlives it
std::unique_ptr<drivers::TimedTracker> cell_tracker(const config::TrackerConfig& config,
                                                    boost::asio::any_io_executor executor,
                                                    drivers::Clock& clock,
                                                    drivers::WireTap tap = drivers::kNullTap,
                                                    net::MakeStream stream = net::tcp_stream);

}  // namespace truepose::daemon
