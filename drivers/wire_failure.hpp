#pragma once

#include <boost/system/error_code.hpp>
#include <string_view>

#include "drivers/wire_tap.hpp"

namespace truepose::drivers {

/// Reports to a tap that an operation on a stream ended with an error. One that was cancelled has not failed.
/// @param operation  "connect", "read" or "write"
void report_failure(const WireTap& tap, std::string_view operation, const boost::system::error_code& error);

}  // namespace truepose::drivers
