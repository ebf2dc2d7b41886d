#include "daemon/cell_tracker.hpp"

#include <utility>

#include "config/air_file.hpp"
#include "daemon/recorder/made_driver.hpp"

namespace truepose::daemon {

std::unique_ptr<drivers::TimedTracker> cell_tracker(const config::TrackerConfig& config,
                                                    boost::asio::any_io_executor executor,
                                                    drivers::Clock& clock, drivers::WireTap tap) {
  return make_tracker(MadeTracker::of(config), {.executor = std::move(executor),
                                                .clock = clock,
                                                .air = config::air_source(config),
                                                .tap = std::move(tap)});
}

}  // namespace truepose::daemon
