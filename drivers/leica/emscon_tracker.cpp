#include "drivers/leica/emscon_tracker.hpp"

#include <optional>
#include <string_view>
#include <utility>

#include "core/planted_bug.hpp"
#include "drivers/deadline.hpp"
#include "drivers/initialise_again.hpp"
#include "drivers/leica/emscon_connection.hpp"
#include "drivers/leica/emscon_settings.hpp"
#include "drivers/plausible_point.hpp"
#include "proto/emscon/status.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using namespace emscon;
using namespace std::chrono_literals;

namespace {

constexpr auto kInitializeTime = 90s;  // AT40x need up to 80 s

/// One finished measurement of either result packet.
struct Reading {
  std::int32_t status = 0;
  SmrPoint point;
};

template <class Result>
Reading reading_of(const Result& result) {
  return {result.status,
          {.p_WS_mm = {result.v[0], result.v[1], result.v[2]},
           .std_mm = {result.std[0], result.std[1], result.std[2]},
           .temperature_c = result.environment.temperature,
           .pressure_mbar = result.environment.pressure,
           .humidity_percent = result.environment.humidity}};
}

TrackerError beam_broken(const std::string& evidence) {
  return {TrackerFault::BeamBroken, "the beam was broken during the measurement: " + evidence};
}

std::optional<TrackerError> laser_trouble(const SystemStatus& system) {
  if (system.laser == LaserStatus::Ready) return std::nullopt;
  const std::string why = system.laser == LaserStatus::HeatingUp ? "is heating up" : "is not ready";
  return TrackerError{TrackerFault::NotReady, "the tracker's laser " + why + " (status " +
                                                  std::to_string(std::to_underlying(system.laser)) + ")"};
}

}  // namespace

/// The dialogue with one tracker, without deadlines.
class EmsconTracker::Session final : public TrackerDialogue {
 public:
  Session(asio::any_io_executor executor, Clock& clock, EmsconOptions options)
      : clock_{clock},
        options_{std::move(options)},
        measure_ms_{static_cast<std::int32_t>(options_.measure.count())},
        connection_{options_.stream(std::move(executor)), clock,
                    [this](const TrackerPacket& packet) { observe(packet); }, options_.tap} {}

  TrackerTask<TrackerIdentity> connect() override;
  TrackerTask<TrackerIdentity> inspect() override;
  TrackerTask<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm) override;
  TrackerTask<SmrPoint> measure() override;
  TrackerTask<void> turn_over() override;
  TrackerTask<void> check() override;
  void average_over(Duration time) override {
    measure_ms_ = static_cast<std::int32_t>(std::chrono::ceil<std::chrono::milliseconds>(time).count());
  }
  void close() noexcept override { connection_.close(); }

 private:
  void observe(const TrackerPacket& packet);
  TrackerResult<std::optional<Air>> air_now() const;
  TrackerTask<bool> begin();
  TrackerTask<void> end_unfinished_measurement();
  TrackerTask<bool> is_locked();
  TrackerTask<SystemStatus> initialize();
  TrackerTask<TrackerIdentity> identity(SystemStatus system);
  TrackerTask<std::int32_t> find_reflector_id();
  TrackerTask<void> set_search(double radius_mm);
  TrackerTask<void> pointed(Command command);
  TrackerTask<void> find_reflector();
  TrackerTask<void> face(std::int32_t wanted);
  TrackerTask<Reading> reading();

  Clock& clock_;
  const EmsconOptions options_;
  std::int32_t measure_ms_;  ///< that each measurement averages over
  EmsconConnection connection_;
  EmsconSettings settings_{connection_};
  InitialiseAgain warm_up_{clock_, options_.initialise_again};
  double distance_mm_ = 0;               ///< of where it was last aimed at
  bool turned_over_ = false;             ///< it may be in face 2
  bool measurement_unfinished_ = false;  ///< started, and its end has not been seen
};

void EmsconTracker::Session::observe(const TrackerPacket& packet) {
  const auto* change = std::get_if<SystemStatusChange>(&packet);
  if (change == nullptr) return;
  settings_.observe(change->event);
  if (change->event == SystemEvent::LaserWarmedUp) warm_up_.has_warmed_up();
}

/// The air to set in the tracker, if any.
TrackerResult<std::optional<Air>> EmsconTracker::Session::air_now() const {
  if (!options_.air) return std::nullopt;
  auto air = options_.air();
  if (!air) return std::unexpected(TrackerError{TrackerFault::NotReady, air.error()});
  return *air;
}

/// What every operation starts with; tells whether a reflector is locked. The question for the lock doubles
/// as a barrier: whatever the tracker had sent before it (a late result, a change by another program) has
/// been read when it is answered.
TrackerTask<bool> EmsconTracker::Session::begin() {
  const auto ended = co_await end_unfinished_measurement();
  if (!ended) co_return std::unexpected(ended.error());
  const auto locked = co_await is_locked();
  if (!locked) co_return std::unexpected(locked.error());
  const auto air = air_now();
  if (!air) co_return std::unexpected(air.error());
  if (*air) settings_.use_air(**air);
  settings_.use_time(measure_ms_);
  if (planted("settings of another program are not checked")) co_return *locked;
  const auto ensured = co_await settings_.ensure();
  if (!ensured) co_return std::unexpected(ensured.error());
  co_return *locked;
}

/// Results carry no command number. So a measurement that was left is stopped, and what it still sent is read
/// away.
TrackerTask<void> EmsconTracker::Session::end_unfinished_measurement() {
  if (!measurement_unfinished_ || planted("an interrupted measurement is not stopped"))
    co_return TrackerResult<void>{};
  Command stop{CommandCode::StopMeasurement, {}};
  const auto answer = co_await connection_.call(std::move(stop));
  if (!answer) co_return std::unexpected(answer.error());
  if (status::is_busy(answer->status)) {
    connection_.close();
    co_return std::unexpected(
        TrackerError{TrackerFault::Disconnected,
                     "the tracker does not stop an earlier measurement; the connection was dropped"});
  }
  measurement_unfinished_ = false;
  co_return TrackerResult<void>{};
}

TrackerTask<bool> EmsconTracker::Session::is_locked() {
  const auto answer =
      co_await connection_.ask(CommandCode::GetMeasurementStatusInfo, "the tracker hides its status");
  if (!answer) co_return std::unexpected(answer.error());
  co_return (std::get<MeasurementStatusInfo>(answer->body).mask & kReflectorFoundBit) != 0;
}

TrackerTask<SystemStatus> EmsconTracker::Session::initialize() {
  const auto before_it =
      co_await connection_.ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!before_it) co_return std::unexpected(before_it.error());
  const SystemStatus& found = std::get<SystemStatus>(before_it->body);
  const bool cold = found.processor != ProcessorStatus::Initialized;
  if (cold) warm_up_.found_cold();
  if (!cold && !warm_up_.is_due()) co_return found;
  if (planted("a tracker that was switched on is not initialised")) co_return found;

  auto initializing = connection_.ask(CommandCode::Initialize, "the tracker cannot be initialised");
  const auto initialized = co_await before(clock_, clock_.now() + kInitializeTime, std::move(initializing));
  if (!initialized) co_return std::unexpected(late("was not initialised"));
  if (!*initialized) co_return std::unexpected(initialized->error());
  warm_up_.done();
  const auto after_it =
      co_await connection_.ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!after_it) co_return std::unexpected(after_it.error());
  co_return std::get<SystemStatus>(after_it->body);
}

TrackerTask<std::int32_t> EmsconTracker::Session::find_reflector_id() {
  Command list{CommandCode::GetReflectors, {}};
  const auto sent = co_await connection_.send(std::move(list));
  if (!sent) co_return std::unexpected(sent.error());
  std::optional<std::int32_t> found;
  std::string known;
  for (std::int32_t count = 1;;) {  // one answer for each reflector; only the total tells which is the last
    const auto packet = co_await connection_.receive();
    if (!packet) co_return std::unexpected(packet.error());
    const auto* answer = std::get_if<Answer>(&*packet);
    if (answer == nullptr || answer->code != CommandCode::GetReflectors) continue;
    if (answer->status != status::kAllOk) {
      co_return std::unexpected(refusal("the tracker hides its reflectors", answer->status));
    }
    const ReflectorEntry& entry = std::get<ReflectorEntry>(answer->body);
    if (entry.total > 0) known += (known.empty() ? "" : ", ") + entry.name;
    const bool any = options_.reflector.empty();
    if (entry.total > 0 && !found && (any || entry.name == options_.reflector)) found = entry.id;
    if (count++ >= entry.total) break;
  }
  if (known.empty()) {
    co_return std::unexpected(
        TrackerError{TrackerFault::Refused,
                     "the tracker lists no reflectors: define one with the tracker's own software"});
  }
  if (!found) {
    co_return std::unexpected(
        TrackerError{TrackerFault::Refused,
                     "the tracker knows no reflector \"" + options_.reflector + "\", only: " + known});
  }
  co_return *found;
}

TrackerTask<void> EmsconTracker::Session::check() {
  const auto answer = co_await connection_.ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!answer) co_return std::unexpected(answer.error());
  if (auto why = laser_trouble(std::get<SystemStatus>(answer->body)))
    co_return std::unexpected(*std::move(why));
  co_return TrackerResult<void>{};
}

TrackerTask<TrackerIdentity> EmsconTracker::Session::connect() {
  measurement_unfinished_ = false;
  const auto opened = co_await connection_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());

  // The order that the maker recommends: units, initialise, everything else.
  Command set_units{CommandCode::SetUnits, kEmsconUnits};
  const auto units = co_await connection_.accepted(std::move(set_units), "the tracker refuses its units");
  if (!units) co_return std::unexpected(units.error());
  const auto system = co_await initialize();
  if (!system) co_return std::unexpected(system.error());
  if (auto why = laser_trouble(*system)) co_return std::unexpected(*std::move(why));
  const auto reflector = co_await find_reflector_id();
  if (!reflector) co_return std::unexpected(reflector.error());

  const auto air = air_now();
  if (!air) co_return std::unexpected(air.error());
  EmsconSettings::Wanted wanted{.measure_ms = measure_ms_,
                                .reflector = *reflector,
                                .has_weather_station = system->weather != WeatherMonitor::NotConnected,
                                .air = *air};
  const auto written = co_await settings_.write(std::move(wanted));
  if (!written) co_return std::unexpected(written.error());
  auto identified = co_await identity(*system);
  co_return std::move(identified);
}

TrackerTask<TrackerIdentity> EmsconTracker::Session::inspect() {
  const auto opened = co_await connection_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());
  const auto answer = co_await connection_.ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!answer) co_return std::unexpected(answer.error());
  const SystemStatus& system = std::get<SystemStatus>(answer->body);
  if (auto why = laser_trouble(system)) co_return std::unexpected(*std::move(why));
  const auto reflector = co_await find_reflector_id();
  if (!reflector) co_return std::unexpected(reflector.error());
  auto identified = co_await identity(system);
  co_return std::move(identified);
}

TrackerTask<TrackerIdentity> EmsconTracker::Session::identity(SystemStatus system) {
  Command get_info{CommandCode::GetTrackerInfo, {}};
  const auto info = co_await connection_.call(std::move(get_info));
  if (!info) co_return std::unexpected(info.error());
  const bool named = info->status == status::kAllOk;
  const auto& [major, minor, build] = system.server_version;
  co_return TrackerIdentity{
      .model = named ? std::get<TrackerInfo>(info->body).name : "emScon tracker",
      .serial = std::to_string(system.serial_number),
      .firmware = std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(build)};
}

TrackerTask<void> EmsconTracker::Session::set_search(double radius_mm) {
  const auto answer = co_await connection_.ask(CommandCode::GetSearchParams, "the tracker hides its search");
  if (!answer) co_return std::unexpected(answer.error());
  const SearchParams wanted{radius_mm, static_cast<std::int32_t>(options_.search_timeout.count())};
  if (std::get<SearchParams>(answer->body) == wanted || planted("the search radius is never set"))
    co_return TrackerResult<void>{};
  Command change{CommandCode::SetSearchParams, wanted};
  const auto set = co_await connection_.accepted(std::move(change), "the tracker refuses the search radius");
  if (!set) co_return std::unexpected(set.error());
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconTracker::Session::aim(Eigen::Vector3d p_W_mm, double search_radius_mm) {
  const auto begun = co_await begin();
  if (!begun) co_return std::unexpected(begun.error());
  if (warm_up_.warmed_up()) co_return std::unexpected(InitialiseAgain::refusal());
  const auto set = co_await set_search(search_radius_mm);
  if (!set) co_return std::unexpected(set.error());

  if (turned_over_) {
    const auto turned = co_await face(1);
    if (!turned) co_return turned;
  }
  Command go{CommandCode::GoPosition, Position{{p_W_mm.x(), p_W_mm.y(), p_W_mm.z()}, true}};
  const auto gone = co_await pointed(std::move(go));
  if (!gone) co_return gone;
  distance_mm_ = p_W_mm.norm();
  auto found = co_await find_reflector();
  co_return found;
}

/// A command by which the tracker is to come to its reflector.
TrackerTask<void> EmsconTracker::Session::pointed(Command command) {
  const auto answer = co_await connection_.call(std::move(command));
  if (!answer) co_return std::unexpected(answer.error());
  if (answer->status == status::kAllOk) co_return TrackerResult<void>{};
  TrackerError error = refusal("no reflector was found where the tracker looked", answer->status);
  // The number of a failed search is not public: what has no other meaning is one.
  if (error.fault == TrackerFault::Refused && !status::is_bad_parameter(answer->status))
    error.fault = TrackerFault::NoTarget;
  co_return std::unexpected(error);
}

/// Around where it points.
TrackerTask<void> EmsconTracker::Session::find_reflector() {
  Command search{CommandCode::FindReflector, SearchDistance{distance_mm_}};
  const auto searched = co_await pointed(std::move(search));
  if (!searched) co_return searched;
  const auto locked = co_await is_locked();
  if (!locked) co_return std::unexpected(locked.error());
  if (!*locked)
    co_return std::unexpected(
        TrackerError{TrackerFault::NoTarget, "the search ended without a locked reflector"});
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconTracker::Session::turn_over() {
  const auto locked = co_await begin();
  if (!locked) co_return std::unexpected(locked.error());
  if (!*locked) co_return std::unexpected(TrackerError{TrackerFault::NoTarget, "no reflector is locked"});
  const auto turned = co_await face(turned_over_ ? 1 : 2);
  if (!turned) co_return turned;
  const auto kept = co_await is_locked();
  if (!kept) co_return std::unexpected(kept.error());
  if (*kept) co_return TrackerResult<void>{};
  auto found = co_await find_reflector();
  co_return found;
}

/// Brings the tracker into face 1 or 2.
TrackerTask<void> EmsconTracker::Session::face(std::int32_t wanted) {
  for (const bool turn : {true, false}) {
    const auto answer = co_await connection_.ask(CommandCode::GetFace, "the tracker hides its face");
    if (!answer) co_return std::unexpected(answer.error());
    turned_over_ = std::get<FaceAnswer>(answer->body).face != 1;
    if (std::get<FaceAnswer>(answer->body).face == wanted) co_return TrackerResult<void>{};
    if (!turn) break;
    const auto turned = co_await connection_.ask(CommandCode::ChangeFace, "the tracker does not turn over");
    if (!turned) co_return std::unexpected(turned.error());
  }
  co_return std::unexpected(
      TrackerError{TrackerFault::Refused, "the tracker does not come into face " + std::to_string(wanted)});
}

/// Starts a measurement and waits for its acceptance and its result, which come in either order.
TrackerTask<Reading> EmsconTracker::Session::reading() {
  measurement_unfinished_ = true;
  Command start{CommandCode::StartMeasurement, {}};
  const auto sent = co_await connection_.send(std::move(start));
  if (!sent) co_return std::unexpected(sent.error());
  bool started = false;
  std::optional<Reading> result;
  while (!started || !result) {
    const auto packet = co_await connection_.receive();
    if (!packet) co_return std::unexpected(packet.error());
    if (const auto* answer = std::get_if<Answer>(&*packet);
        answer && answer->code == CommandCode::StartMeasurement) {
      if (answer->status != status::kAllOk) {
        measurement_unfinished_ = false;
        co_return std::unexpected(refusal("the tracker does not measure", answer->status));
      }
      started = true;
    } else if (const auto* error = std::get_if<ErrorReport>(&*packet)) {
      co_return std::unexpected(beam_broken(describe_status(error->status)));
    } else if (const auto* change = std::get_if<SystemStatusChange>(&*packet)) {
      if (change->event == SystemEvent::MeasurementNotReady && !planted("a broken beam is waited for")) {
        co_return std::unexpected(beam_broken("the tracker is not able to measure points (event 25)"));
      }
    } else if (const auto* single = std::get_if<SingleMeasResult>(&*packet)) {
      result = reading_of(*single);
    } else if (const auto* extended = std::get_if<SingleMeasResult2>(&*packet)) {
      result = reading_of(*extended);
    }
  }
  measurement_unfinished_ = false;
  co_return *result;
}

TrackerTask<SmrPoint> EmsconTracker::Session::measure() {
  const auto locked = co_await begin();
  if (!locked) co_return std::unexpected(locked.error());
  if (!*locked) co_return std::unexpected(TrackerError{TrackerFault::NoTarget, "no reflector is locked"});

  const auto result = co_await reading();
  if (!result) co_return std::unexpected(result.error());
  if (result->status != status::kAllOk) {
    TrackerError error = refusal("the measurement failed", result->status);
    if (error.fault == TrackerFault::Refused) error.fault = TrackerFault::BeamBroken;
    co_return std::unexpected(error);
  }
  if (!result->point.p_WS_mm.allFinite()) {
    co_return std::unexpected(
        TrackerError{TrackerFault::Protocol, "the tracker sent a point that is not a number"});
  }
  if (auto why_not = implausible(result->point); why_not && !planted("a point of impossible air is taken"))
    co_return std::unexpected(TrackerError{TrackerFault::Refused, *std::move(why_not)});
  if (settings_.in_doubt()) {
    co_return std::unexpected(TrackerError{
        TrackerFault::NotReady, "another program changed the tracker's settings during the measurement"});
  }
  co_return result->point;
}

EmsconTracker::EmsconTracker(asio::any_io_executor executor, Clock& clock, EmsconOptions options)
    : TimedTracker{clock, std::make_unique<Session>(std::move(executor), clock, std::move(options))} {}

}  // namespace truepose::drivers
