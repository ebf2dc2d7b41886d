#include "daemon/recorder/made_driver.hpp"

#include <array>
#include <utility>

#include "daemon/recorder/record_forms.hpp"
#include "drivers/bridge/bridge_tracker.hpp"
#include "drivers/leica/emscon_tracker.hpp"

namespace truepose {

namespace eki {

namespace {

constexpr std::array kCommandTypes{Named{"ptp", CommandType::Ptp}, Named{"start-rsi", CommandType::StartRsi},
                                   Named{"no-op", CommandType::NoOp}};

}  // namespace

/// As a driver remembers it, to the last digit.
struct RememberedCommand {
  Command command;
};
void layout(auto& io, record::Is<RememberedCommand> auto& x) {
  io("id", x.command.id);
  io("type", x.command.type, kCommandTypes);
  io("velocity_percent", x.command.velocity_percent);
  io("acceleration_percent", x.command.acceleration_percent);
  io("settle_ms", x.command.settle_ms);
  io("axes_rad", x.command.axes_rad, record::Digits<Axes>{});
}

}  // namespace eki

namespace drivers {

namespace {

struct Remembered {
  eki::RememberedCommand form_of(const eki::Command& command) const { return {command}; }
  eki::Command value_of(const eki::RememberedCommand& form) const { return form.command; }
};

}  // namespace

void layout(auto& io, record::Is<KukaEkiMemory> auto& x) {
  io("last_id", x.last_id, record::Whole{0, 2'000'000'000});
  io.optional("unfinished", x.unfinished, Remembered{});
}

void layout(auto& io, record::Is<TrackerMemory> auto& x) {
  io.optional("cold_since_ns", x.warm_up.cold_since, record::Nanoseconds{}, record::kTime);
  io("warmed_up", x.warm_up.warmed_up);
  io("average_ms", x.average, record::kMs);
  io("last_request", x.last_request, record::kCounter);
  io("distance_mm", x.distance_mm, record::OneInDigits{});
  io("turned_over", x.turned_over);
}

}  // namespace drivers

namespace daemon {

void layout(auto& io, record::Is<MadeRobot> auto& x) {
  io("host", x.host);
  io("motion_port", x.motion_port, record::Whole{0, 65'535});
  io("state_port", x.state_port, record::Whole{0, 65'535});
  io("joint_count", x.joint_count, record::Whole{1, 6});
  io("memory", x.memory);
}

void layout(auto& io, record::Is<MadeTracker> auto& x) {
  io("protocol", x.protocol, config::kTrackerProtocols);
  io("host", x.host);
  io("port", x.port, record::Whole{0, 65'535});
  io("reflector", x.reflector);
  io("measure_ms", x.measure, record::kMs);
  io("initialise_again_min", x.initialise_again, record::Whole{0, 10'000'000});
  io("told_air", x.told_air);
  io.optional("memory", x.memory);
}

MadeRobot MadeRobot::of(const drivers::KukaEkiRobot& robot) {
  const drivers::KukaEkiOptions& options = robot.options();
  return {options.host, options.motion_port, options.state_port, options.joint_count, robot.memory()};
}

drivers::KukaEkiOptions MadeRobot::options() const {
  return {.host = host,
          .motion_port = motion_port,
          .state_port = state_port,
          .joint_count = joint_count,
          .memory = memory};
}

std::string text(const MadeRobot& robot) { return record::text_of(robot); }
std::expected<MadeRobot, std::string> read_robot(std::string_view text) {
  return record::read_text<MadeRobot>(text, "driver");
}

MadeTracker MadeTracker::of(const config::TrackerConfig& config) {
  return {.protocol = config.protocol,
          .host = config.address.host,
          .port = config.address.port,
          .reflector = config.reflector,
          .measure = config.measure,
          .initialise_again = config.reinitialise_after,
          .told_air = config.air || !config.air_file.empty(),
          .memory = {}};
}

std::string text(const MadeTracker& tracker) { return record::text_of(tracker); }
std::expected<MadeTracker, std::string> read_tracker(std::string_view text) {
  return record::read_text<MadeTracker>(text, "driver");
}

namespace {

/// What the options of every driver have.
template <class Options>
Options options_of(const MadeTracker& made, TrackerSurroundings surroundings) {
  Options options;
  options.host = made.host;
  options.port = made.port;
  options.reflector = made.reflector;
  options.measure = made.measure;
  options.initialise_again = made.initialise_again;
  options.memory = made.memory;
  options.tap = surroundings.tap;
  options.stream = std::move(surroundings.stream);
  if (made.told_air)
    options.air = [air = std::move(surroundings.air), tap = std::move(surroundings.tap)] {
      ToldAir told = air();
      tap(recording::Kind::Air, text(told));
      return told;
    };
  return options;
}

}  // namespace

std::unique_ptr<drivers::TimedTracker> make_tracker(const MadeTracker& made,
                                                    TrackerSurroundings surroundings) {
  const boost::asio::any_io_executor executor = surroundings.executor;
  drivers::Clock& clock = surroundings.clock;
  switch (made.protocol) {
    case config::TrackerProtocol::Bridge:
      return std::make_unique<drivers::BridgeTracker>(
          executor, clock, options_of<drivers::BridgeOptions>(made, std::move(surroundings)));
    case config::TrackerProtocol::Emscon:
      break;
  }
  return std::make_unique<drivers::EmsconTracker>(
      executor, clock, options_of<drivers::EmsconOptions>(made, std::move(surroundings)));
}

}  // namespace daemon
}  // namespace truepose
