#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>

#include "config/cell_config.hpp"
#include "core/arm/robot_model.hpp"
#include "core/compensate/correction_bounds.hpp"
#include "core/math/units.hpp"
#include "drivers/clock.hpp"
#include "proto/rsi/ethernet_config.hpp"

namespace truepose::daemon {

/// A controller from which nothing came for so long is silent: it sends every 4 or 12 ms.
inline constexpr std::chrono::milliseconds kSilence{400};

/// How the stream behaves. A cycle is a step of the controller's IPOC, never of this machine's clock.
struct StreamOptions {
  double max_step_rad = 0;
  double max_total_rad = 0;
  double limit_margin_rad = 0;
  double singular_below_rad = 0;  ///< CompensationOptions::singular_below
  int ramp_cycles = 250;          ///< from no correction to all of it, and from one model to the next
  int broken_cycles = 250;        ///< a bound broken for so many in a row is a fault
  double following_tolerance_rad = 0.05 * kRadPerDeg;  ///< measured and sent correction may differ by so much
  int rejected_cycles = 8;   ///< so many late replies in a row that were sent in time are a fault
  int timeout_cycles = 100;  ///< the controller's: a packet further ahead must be borne out by others
  std::chrono::milliseconds cycle{4};
  /// After no packet of the controller for this long the stream must be started again. None: it resumes by
  /// itself.
  std::optional<std::chrono::milliseconds> disarm_after = kSilence;
  std::optional<std::uint32_t> peer;     ///< the controller's IPv4 address; none: any
  double max_fk_deviation_mm = 1;        ///< RIst against the nominal arm at AIPos
  bool never_corrected = false;          ///< no process of this cell has ever sent a correction but zero
  drivers::TimePoint listening_since{};  ///< before, another process may have replied to the controller

  static StreamOptions of(const config::CellConfig& cell);

  double cycles_per_second() const { return 1000.0 / static_cast<double>(cycle.count()); }
  CorrectionBounds bounds(const RobotModel& robot) const;
};

/// Why the daemon cannot drive this arm, in one sentence; nothing where it can.
std::optional<std::string> why_unfit(const RobotModel& nominal);
/// Why this arm cannot be corrected under these options by a controller of that configuration, in one
/// sentence; nothing where it can.
std::optional<std::string> why_unfit(const RobotModel& nominal, const rsi::EthernetConfig& ethernet,
                                     const StreamOptions& options);

/// Reads the RSI ethernet configuration that the controller loads as well. The error is one sentence that
/// names the file.
std::expected<rsi::EthernetConfig, std::string> read_ethernet(const std::filesystem::path& file);

}  // namespace truepose::daemon
