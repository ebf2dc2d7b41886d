#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "config/cell_config.hpp"
#include "daemon/recorder/driver_call.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/timed_tracker.hpp"
#include "drivers/wire_tap.hpp"

/// How drivers are made, so that a replay makes the same ones.
namespace truepose::daemon {

struct MadeRobot {
  std::string host;
  std::uint16_t motion_port = 0, state_port = 0;
  int joint_count = 6;
  drivers::KukaEkiMemory memory;

  /// As it is now.
  static MadeRobot of(const drivers::KukaEkiRobot& robot);
  /// Without taps and streams.
  drivers::KukaEkiOptions options() const;
};
std::string text(const MadeRobot& robot);
std::expected<MadeRobot, std::string> read_robot(std::string_view text);

struct MadeTracker {
  config::TrackerProtocol protocol = config::TrackerProtocol::Emscon;
  std::string host;
  std::uint16_t port = 0;
  std::string reflector;
  std::chrono::milliseconds measure{0};
  std::chrono::minutes initialise_again{0};
  bool told_air = false;  ///< asks for the air
  std::optional<drivers::TrackerMemory> memory;

  static MadeTracker of(const config::TrackerConfig& config);
};
std::string text(const MadeTracker& tracker);
std::expected<MadeTracker, std::string> read_tracker(std::string_view text);

/// What a tracker's driver works with.
struct TrackerSurroundings {
  boost::asio::any_io_executor executor;
  drivers::Clock& clock;  ///< outlives it
  std::function<ToldAir()> air{};
  drivers::WireTap tap = drivers::kNobodyHears;
  drivers::MakeStream stream = drivers::tcp_stream;
};
/// The tap also hears what the driver is told of the air.
std::unique_ptr<drivers::TimedTracker> make_tracker(const MadeTracker& made,
                                                    TrackerSurroundings surroundings);

}  // namespace truepose::daemon
