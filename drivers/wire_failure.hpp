#pragma once

#include <array>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

#include "core/named.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::drivers {

enum class WireOperation : std::uint8_t { Connect, Read, Write };
inline constexpr std::array kWireOperations{Named{"connect", WireOperation::Connect},
                                            Named{"read", WireOperation::Read},
                                            Named{"write", WireOperation::Write}};

/// An operation on a stream that ended with an error.
struct WireFailure {
  WireOperation operation = WireOperation::Read;
  boost::system::error_code error;
};

/// "connect system:111 Connection refused"
std::string text(const WireFailure& failure);
/// Error: one phrase on what of it is unknown.
std::expected<WireFailure, std::string> read_failure(std::string_view text);

/// Lets a tap hear how an operation ended, where that was with an error. What was cancelled has not failed,
/// but for a write: its bytes may be on their way.
void tell_failure(const WireTap& tap, WireOperation operation, const boost::system::error_code& error);

}  // namespace truepose::drivers
