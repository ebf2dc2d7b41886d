#pragma once

#include <optional>
#include <string_view>

namespace truepose {

/// How a moment is said. Moments of different forms have no origin in common.
enum class TimeForm {
  Number,  ///< a number, since whenever
  Local,   ///< date and time of day of some zone
  Zoned,   ///< with the zone
};

/// When a point was measured.
struct MeasuredTime {
  TimeForm form = TimeForm::Number;
  double seconds = 0;  ///< since some moment, the same for all of one form
};

/// Reads date and time by ISO 8601 ("2026-11-26T08:00:30", a blank in place of the T, with or without a
/// fraction and a zone: "Z", "+01:00", "+0100") or a number of seconds of up to kMostSeconds. Dates that
/// other orders of day and month could mean, and a time of day alone, are not read.
std::optional<MeasuredTime> measured_time(std::string_view text);

/// More than any clock counts in seconds: milliseconds since 1970 are.
inline constexpr double kMostSeconds = 1e11;

}  // namespace truepose
