#pragma once

#include <chrono>
#include <string>

namespace truepose::control {

/// UTC with milliseconds: "2026-11-21T10:48:00.123Z".
std::string rfc3339(std::chrono::system_clock::time_point time);

}  // namespace truepose::control
