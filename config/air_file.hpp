#pragma once

#include <expected>
#include <filesystem>
#include <functional>
#include <string>

#include "config/cell_config.hpp"
#include "core/math/refraction.hpp"

namespace truepose::config {

/// Reads {temperature_c, pressure_mbar, humidity_percent} (YAML or JSON), all of which must be there. Throws
/// ConfigError.
Air load_air(const std::filesystem::path& file);

/// Tells the air of the cell as it is now: what was entered, or what tracker.air_file says at that moment.
/// Empty where the tracker has to know by itself. Errors: the file cannot be read, is older than
/// tracker.air_max_age_s or dated later than now, or holds no air that there is.
std::function<std::expected<Air, std::string>()> air_source(const TrackerConfig& tracker);

}  // namespace truepose::config
