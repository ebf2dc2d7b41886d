#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/refraction.hpp"
#include "drivers/leica/emscon_connection.hpp"

namespace truepose::drivers {

/// Everything in a tracker that its coordinates depend on: written, read back, and written again where
/// another program has changed it.
class EmsconSettings {
 public:
  /// What they are to be.
  struct Wanted {
    std::int32_t measure_ms = 2000;
    std::int32_t reflector = 0;  ///< by the tracker's number
    bool has_weather_station = true;
    std::optional<Air> air;  ///< to reckon with in place of the station's; none: as the tracker finds it
  };

  /// @param connection  outlives the settings
  explicit EmsconSettings(EmsconConnection& connection) : connection_{connection} {}

  void observe(emscon::SystemEvent event);
  /// Writes all of them and reads them back.
  TrackerTask<void> write(Wanted wanted);
  // From the next ensure() on:
  void use_air(const Air& air);  ///< only if the air is configured
  void use_time(std::int32_t measure_ms);
  /// Reads them back if another program may have changed one, and writes them again if it has.
  TrackerTask<void> ensure();
  /// Whether another program may have changed one since they were last read.
  bool in_doubt() const { return in_doubt_; }

 private:
  struct Setting {
    emscon::CommandCode set, get;
    emscon::Body wanted;
    std::string_view name;
    emscon::Body before = {};  ///< is written first; none: nothing
  };
  static std::vector<Setting> settings_of(const Wanted& wanted);
  static std::string described(const Setting& setting, const emscon::Body& found);
  void want(const Wanted& wanted);
  TrackerTask<void> write_all();
  TrackerTask<std::string> first_wrong();

  EmsconConnection& connection_;
  Wanted wanted_;
  std::vector<Setting> settings_;
  bool in_doubt_ = true;
};

/// The units that everything is written and read in: mm, rad, C, mbar.
extern const emscon::Units kEmsconUnits;

}  // namespace truepose::drivers
