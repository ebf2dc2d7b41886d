#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/world/soak_log.hpp"

namespace truepose::world {

struct SoakOptions {
  std::uint64_t seed = 1;
  double days = 1;
  std::optional<std::set<std::string>> faults{};  ///< by their names; none: all
  /// Ends there in the middle of everything, with nothing judged at the end; none: at its end.
  std::optional<std::chrono::milliseconds> until{};
  double production_h_per_day = 2;  ///< at most, of programs under correction
  /// Computes as the programs do on this processor; histories are then the same on its like alone.
  bool own_kernels = false;
  /// Called with each event of the daemon's, and each fault as it begins and ends.
  SoakLog::Trace trace = [](auto&&...) {};
};

/// Reads what time_text() writes; nothing where it is none.
std::optional<std::chrono::milliseconds> time_in(const std::string& text);

struct SoakReport {
  std::vector<BrokenPromise> broken;
  std::uint64_t hash = 0;
  int campaigns = 0, programs = 0, restarts = 0;
  std::uint64_t points = 0, points_compared = 0, looks = 0, statuses_compared = 0, events_compared = 0,
                drift_checks = 0, corrections_compared = 0, cycles = 0, sessions = 0;
  double largest_step_deg = 0, largest_point_error_mm = 0, largest_model_error_mm = 0;
  double largest_correction_error_mm = 0;
  double largest_model_ratio = 0;  ///< of a green model's error to its validation's
  std::int64_t largest_daemon_bytes = 0, largest_left_bytes = 0;  ///< of memory; left by one that has ended
  std::set<std::string> methods;                                  ///< that clients asked for
  std::map<std::string, int> faults;                              ///< that happened, by their names
};

/// A cell for as long as one likes, with people who calibrate, produce and repair, and all that goes wrong.
/// The same seed does the same again, bit for bit.
SoakReport soak(const SoakOptions& options);

}  // namespace truepose::world
