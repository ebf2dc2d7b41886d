#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/recorder/driver_call.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/clock.hpp"
#include "proto/recording/record.hpp"

namespace truepose::daemon {

/// A driver of a robot or a tracker that is made as a recorded one was, and recorded as that was.
class ReplayedDriver {
 public:
  virtual ~ReplayedDriver() = default;
  /// One of the calls that have an outcome, which is recorded. One that the driver does not have is passed
  /// over.
  virtual boost::asio::awaitable<void> make(DriverCall call) = 0;
  /// One of the others.
  virtual void make_at_once(const DriverCall& call) = 0;
};

/// What it works with.
struct ReplaySurroundings {
  boost::asio::any_io_executor executor;
  drivers::Clock& clock;  ///< outlives the driver
  /// Hears what is recorded.
  std::function<void(recording::Wire wire, recording::Kind kind, std::string_view bytes)> tell;
  std::function<std::unique_ptr<drivers::ByteStream>(recording::Wire wire)> stream;
  std::function<ToldAir()> air;
  std::uint64_t calls = 0;  ///< number of the call before the first
};

/// @param made  a record of the kind Driver. Error: one sentence on why it makes none
std::expected<std::unique_ptr<ReplayedDriver>, std::string> replayed_driver(const recording::Record& made,
                                                                            ReplaySurroundings surroundings);

}  // namespace truepose::daemon
