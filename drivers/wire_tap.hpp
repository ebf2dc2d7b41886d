#pragma once

#include <functional>
#include <string_view>

#include "proto/recording/record.hpp"

namespace truepose::drivers {

/// Hears all that goes over one wire, when it went: Received, Sent, Connected, Closed and Failed.
using WireTap = std::function<void(recording::Kind kind, std::string_view bytes)>;

inline const WireTap kNullTap = [](recording::Kind, std::string_view) {};

}  // namespace truepose::drivers
