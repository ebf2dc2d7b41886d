#pragma once

#include <boost/system/error_code.hpp>
#include <chrono>
#include <string_view>

#include "drivers/net/stream.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::drivers {

/// In which a device that is there takes a connection.
inline constexpr std::chrono::seconds kTaken{2};

/// Reports to a tap that a connection stands, and between which ends.
void report_connected(const WireTap& tap, const net::Stream& stream);

/// Reports to a tap that an operation on a stream ended with an error. One that was cancelled has not failed.
/// @param operation  "connect", "read" or "write"
void report_failure(const WireTap& tap, std::string_view operation, const boost::system::error_code& error);

}  // namespace truepose::drivers
