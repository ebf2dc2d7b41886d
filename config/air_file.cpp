#include "config/air_file.hpp"

#include <system_error>

#include "config/yaml_layout.hpp"
#include "core/formatted.hpp"

namespace truepose::config {
namespace {

constexpr std::chrono::minutes kClocksDiffer{1};  // of two machines

std::expected<Air, std::string> recent_air(const std::filesystem::path& file, std::chrono::seconds max_age) {
  std::error_code failed;
  const auto written = std::filesystem::last_write_time(file, failed);
  if (failed) return std::unexpected(file.string() + ": cannot be read: " + failed.message());
  const auto age = std::chrono::floor<std::chrono::seconds>(decltype(written)::clock::now() - written);
  if (age < -kClocksDiffer)
    return std::unexpected(formatted(
        "%s: is dated %lld s later than now, so its age is unknown: set the clocks of this PC and of "
        "the weather station",
        file.c_str(), static_cast<long long>(-age.count())));
  if (age > max_age)
    return std::unexpected(formatted(
        "%s: was written %lld s ago, allowed are %lld s (tracker.air_max_age_s): "
        "see that the weather station runs",
        file.c_str(), static_cast<long long>(age.count()), static_cast<long long>(max_age.count())));
  try {
    return load_air(file);
  } catch (const ConfigError& e) {
    return std::unexpected(e.what());
  }
}

}  // namespace

Air load_air(const std::filesystem::path& file) {
  Air air;
  read_value(read_yaml(file), air);
  return air;
}

std::function<std::expected<Air, std::string>()> air_source(const TrackerConfig& tracker) {
  if (tracker.air) return [air = *tracker.air] { return air; };
  if (tracker.air_file.empty()) return {};
  return [file = tracker.air_file, max_age = tracker.air_max_age] { return recent_air(file, max_age); };
}

}  // namespace truepose::config
