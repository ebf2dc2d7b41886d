#include "daemon/cell_tracker.hpp"

#include <utility>

#include "config/air_file.hpp"
#include "drivers/bridge/bridge_tracker.hpp"
#include "drivers/leica/emscon_tracker.hpp"

namespace truepose::daemon {
namespace {

/// What the options of every driver have.
template <class Options>
Options options_of(const config::TrackerConfig& config, drivers::WireTap tap, net::MakeStream stream) {
  Options options;
  options.host = config.address.host;
  options.port = config.address.port;
  options.reflector = config.reflector;
  options.measure = config.measure;
  options.initialise_again = config.reinitialise_after;
  options.air = config::air_source(config);
  options.tap = std::move(tap);
  options.stream = std::move(stream);
  return options;
}

}  // namespace

std::unique_ptr<drivers::TimedTracker> cell_tracker(const config::TrackerConfig& config,
                                                    boost::asio::any_io_executor executor,
                                                    drivers::Clock& clock, drivers::WireTap tap,
                                                    net::MakeStream stream) {
  switch (config.protocol) {
    case config::TrackerProtocol::Bridge:
      return std::make_unique<drivers::BridgeTracker>(
          std::move(executor), clock,
          options_of<drivers::BridgeOptions>(config, std::move(tap), std::move(stream)));
    case config::TrackerProtocol::Emscon:
      break;
  }
  return std::make_unique<drivers::EmsconTracker>(
      std::move(executor), clock,
      options_of<drivers::EmsconOptions>(config, std::move(tap), std::move(stream)));
}

}  // namespace truepose::daemon
