#include "drivers/leica/emscon_tracker.hpp"

#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/deadline.hpp"
#include "drivers/leica/emscon_connection.hpp"
#include "drivers/plausible_point.hpp"
#include "proto/emscon/status.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using namespace emscon;
using namespace std::chrono_literals;

namespace {

constexpr auto kInitializeTime = 90s;  // AT40x need up to 80 s
constexpr Units kUnits{LengthUnit::Millimeter, AngleUnit::Radian, TemperatureUnit::Celsius,
                       PressureUnit::Mbar, HumidityUnit::RelativePercent};

/// Something in the tracker that coordinates depend on, and what it has to be.
struct Setting {
  CommandCode set, get;
  Body wanted;
  std::string_view name;
};

/// What a tracker may report otherwise than it was written: ignored by some models, or a fact of the
/// hardware.
Body without_hardware_facts(Body body) {
  if (auto* params = std::get_if<StationaryModeParams>(&body)) params->use_adm = true;
  if (auto* settings = std::get_if<SystemSettings>(&body)) {
    settings->try_mode = 0;
    settings->has_nivel = false;
    settings->has_video_camera = false;
  }
  return body;
}

bool concerns_settings(SystemEvent event) {
  switch (event) {
    case SystemEvent::UnitsChanged:
    case SystemEvent::ReflectorChanged:
    case SystemEvent::SystemSettingsChanged:
    case SystemEvent::CoordinateSystemChanged:
    case SystemEvent::StationOrientationChanged:
    case SystemEvent::TransformationChanged:
    case SystemEvent::MeasurementModeChanged:
    case SystemEvent::StationaryParamsChanged:
      return true;
    default:
      return false;
  }
}

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

std::string_view name_at(std::span<const std::string_view> names, auto unit) {
  const auto index = static_cast<std::size_t>(std::to_underlying(unit));
  return index < names.size() ? names[index] : "unknown";
}

/// "mm, rad, C, mbar"
std::string described(const Units& units) {
  constexpr std::string_view kLengths[] = {"m", "mm", "um", "ft", "yd", "in"};
  constexpr std::string_view kAngles[] = {"rad", "deg", "gon"};
  constexpr std::string_view kTemperatures[] = {"C", "F"};
  constexpr std::string_view kPressures[] = {"mbar", "hPa", "kPa", "mmHg", "psi", "inH2O", "inHg"};
  std::string text{name_at(kLengths, units.length)};
  text.append(", ").append(name_at(kAngles, units.angle));
  text.append(", ").append(name_at(kTemperatures, units.temperature));
  return text.append(", ").append(name_at(kPressures, units.pressure));
}

/// "reflector", and what is there in its place where that can be said.
std::string described(const Setting& setting, const Body& found) {
  std::string text{setting.name};
  const auto* units = std::get_if<Units>(&found);
  if (units != nullptr) text += " (it has " + described(*units) + ", needed are " + described(kUnits) + ")";
  return text;
}

TrackerError beam_broken(const std::string& evidence) {
  return {TrackerFault::BeamBroken, "the beam was broken during the measurement: " + evidence};
}

TrackerError late(std::string_view what) {
  return {TrackerFault::Timeout, "the tracker " + std::string{what} + " before the deadline"};
}

std::optional<TrackerError> laser_trouble(const SystemStatus& system) {
  if (system.laser == LaserStatus::Ready) return std::nullopt;
  const std::string why = system.laser == LaserStatus::HeatingUp ? "is heating up" : "is not ready";
  return TrackerError{TrackerFault::NotReady, "the tracker's laser " + why + " (status " +
                                                  std::to_string(std::to_underlying(system.laser)) + ")"};
}

}  // namespace

/// The dialogue with one tracker, without deadlines.
class EmsconTracker::Session {
 public:
  Session(asio::any_io_executor executor, Clock& the_clock, EmsconOptions options)
      : clock{the_clock},
        options_{std::move(options)},
        connection_{std::move(executor), [this](const TrackerPacket& packet) { observe(packet); },
                    options_.tap} {}

  TrackerTask<TrackerIdentity> connect();
  TrackerTask<TrackerIdentity> inspect();
  TrackerTask<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm);
  TrackerTask<SmrPoint> measure();
  TrackerTask<void> check();
  void close() noexcept { connection_.close(); }

  Clock& clock;

 private:
  void observe(const TrackerPacket& packet);
  TrackerTask<Answer> accepted(Command command, std::string_view what);
  TrackerTask<Answer> ask(CommandCode code, std::string_view what);
  TrackerTask<bool> begin();
  TrackerTask<void> end_unfinished_measurement();
  TrackerTask<bool> is_locked();
  TrackerTask<SystemStatus> initialize();
  TrackerTask<TrackerIdentity> identity(SystemStatus system);
  TrackerTask<std::int32_t> find_reflector_id();
  TrackerTask<void> set_search(double radius_mm);
  TrackerTask<void> write_settings();
  TrackerTask<std::string> first_wrong_setting();
  TrackerTask<void> ensure_settings();
  TrackerTask<Reading> reading();

  const EmsconOptions options_;
  EmsconConnection connection_;
  std::vector<Setting> settings_;
  bool settings_in_doubt_ = true;
  bool measurement_unfinished_ = false;  ///< started, and its end has not been seen
};

void EmsconTracker::Session::observe(const TrackerPacket& packet) {
  const auto* change = std::get_if<SystemStatusChange>(&packet);
  if (change != nullptr && concerns_settings(change->event)) settings_in_doubt_ = true;
}

/// The answer to a command, a refusal turned into an error.
TrackerTask<Answer> EmsconTracker::Session::accepted(Command command, std::string_view what) {
  auto answer = co_await connection_.call(std::move(command));
  if (answer && answer->status != status::kAllOk) co_return std::unexpected(refusal(what, answer->status));
  co_return answer;
}

/// The same for a command without a body.
TrackerTask<Answer> EmsconTracker::Session::ask(CommandCode code, std::string_view what) {
  Command command{code, {}};
  auto answer = co_await accepted(std::move(command), what);
  co_return answer;
}

/// What every operation starts with; tells whether a reflector is locked. The question for the lock doubles
/// as a barrier: whatever the tracker had sent before it (a late result, a change by another program) has
/// been read when it is answered.
TrackerTask<bool> EmsconTracker::Session::begin() {
  const auto ended = co_await end_unfinished_measurement();
  if (!ended) co_return std::unexpected(ended.error());
  const auto locked = co_await is_locked();
  if (!locked) co_return std::unexpected(locked.error());
  const auto ensured = co_await ensure_settings();
  if (!ensured) co_return std::unexpected(ensured.error());
  co_return *locked;
}

/// Results carry no command number. So a measurement that was left is stopped, and what it still sent is read
/// away.
TrackerTask<void> EmsconTracker::Session::end_unfinished_measurement() {
  if (!measurement_unfinished_) co_return TrackerResult<void>{};
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
  const auto answer = co_await ask(CommandCode::GetMeasurementStatusInfo, "the tracker hides its status");
  if (!answer) co_return std::unexpected(answer.error());
  co_return (std::get<MeasurementStatusInfo>(answer->body).mask & kReflectorFoundBit) != 0;
}

TrackerTask<SystemStatus> EmsconTracker::Session::initialize() {
  const auto before_it = co_await ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!before_it) co_return std::unexpected(before_it.error());
  const SystemStatus& found = std::get<SystemStatus>(before_it->body);
  if (found.processor == ProcessorStatus::Initialized) co_return found;

  auto initializing = ask(CommandCode::Initialize, "the tracker cannot be initialised");
  const auto initialized = co_await before(clock, clock.now() + kInitializeTime, std::move(initializing));
  if (!initialized) co_return std::unexpected(late("was not initialised"));
  if (!*initialized) co_return std::unexpected(initialized->error());
  const auto after_it = co_await ask(CommandCode::GetSystemStatus, "the tracker hides its status");
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

TrackerTask<void> EmsconTracker::Session::write_settings() {
  for (const Setting& setting : settings_) {
    const std::string what = "the tracker refuses its " + std::string{setting.name};
    Command write{setting.set, setting.wanted};
    const auto answer = co_await accepted(std::move(write), what);
    if (!answer) co_return std::unexpected(answer.error());
  }
  co_return TrackerResult<void>{};
}

/// @return which setting is not as wanted, or nothing
TrackerTask<std::string> EmsconTracker::Session::first_wrong_setting() {
  for (const Setting& setting : settings_) {
    const std::string what = "the tracker hides its " + std::string{setting.name};
    const auto answer = co_await ask(setting.get, what);
    if (!answer) co_return std::unexpected(answer.error());
    if (without_hardware_facts(answer->body) != without_hardware_facts(setting.wanted))
      co_return described(setting, answer->body);
  }
  co_return std::string{};
}

/// Reads the settings back, and writes them again where another program has changed them. Reading first,
/// because every write raises events that cannot be told from another program's.
TrackerTask<void> EmsconTracker::Session::ensure_settings() {
  std::string wrong;
  for (int attempt = 0; settings_in_doubt_ && attempt < 3; ++attempt) {
    settings_in_doubt_ = false;
    const auto checked = co_await first_wrong_setting();
    if (!checked) settings_in_doubt_ = true;
    if (!checked) co_return std::unexpected(checked.error());
    wrong = *checked;
    if (wrong.empty()) continue;
    const auto written = co_await write_settings();
    settings_in_doubt_ = true;
    if (!written) co_return std::unexpected(written.error());
  }
  if (settings_in_doubt_) {
    const std::string name = wrong.empty() ? "settings" : wrong;
    co_return std::unexpected(
        TrackerError{TrackerFault::NotReady,
                     "the tracker does not keep its " + name + ": does another program change them?"});
  }
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconTracker::Session::check() {
  const auto answer = co_await ask(CommandCode::GetSystemStatus, "the tracker hides its status");
  if (!answer) co_return std::unexpected(answer.error());
  if (auto why = laser_trouble(std::get<SystemStatus>(answer->body)))
    co_return std::unexpected(*std::move(why));
  co_return TrackerResult<void>{};
}

TrackerTask<TrackerIdentity> EmsconTracker::Session::connect() {
  measurement_unfinished_ = false;
  settings_in_doubt_ = true;
  const auto opened = co_await connection_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());

  // The order that the maker recommends: units, initialise, everything else.
  Command set_units{CommandCode::SetUnits, kUnits};
  const auto units = co_await accepted(std::move(set_units), "the tracker refuses its units");
  if (!units) co_return std::unexpected(units.error());
  const auto system = co_await initialize();
  if (!system) co_return std::unexpected(system.error());
  if (auto why = laser_trouble(*system)) co_return std::unexpected(*std::move(why));
  const auto reflector = co_await find_reflector_id();
  if (!reflector) co_return std::unexpected(reflector.error());

  const bool has_weather = system->weather != WeatherMonitor::NotConnected;
  const SystemSettings system_settings{
      .weather = has_weather ? WeatherMonitor::ReadAndCompute : WeatherMonitor::NotConnected,
      .keep_last_position = true,
      .send_unsolicited_messages = true};
  settings_ = {
      {CommandCode::SetUnits, CommandCode::GetUnits, kUnits, "units"},
      {CommandCode::SetCoordinateSystemType, CommandCode::GetCoordinateSystemType, CoordinateSystemChoice{},
       "coordinate system"},
      {CommandCode::SetSystemSettings, CommandCode::GetSystemSettings, system_settings, "system settings"},
      {CommandCode::SetTransformationParams, CommandCode::GetTransformationParams, Transformation{},
       "transformation"},
      {CommandCode::SetStationOrientationParams, CommandCode::GetStationOrientationParams,
       StationOrientation{}, "station orientation"},
      {CommandCode::SetMeasurementMode, CommandCode::GetMeasurementMode, MeasurementModeChoice{},
       "measurement mode"},
      {CommandCode::SetStationaryModeParams, CommandCode::GetStationaryModeParams,
       StationaryModeParams{static_cast<std::int32_t>(options_.measure.count()), true}, "measuring time"},
      {CommandCode::SetReflector, CommandCode::GetReflector, ReflectorChoice{*reflector}, "reflector"},
  };
  const auto written = co_await write_settings();
  if (!written) co_return std::unexpected(written.error());
  const auto ensured = co_await ensure_settings();
  if (!ensured) co_return std::unexpected(ensured.error());
  auto identified = co_await identity(*system);
  co_return std::move(identified);
}

TrackerTask<TrackerIdentity> EmsconTracker::Session::inspect() {
  const auto opened = co_await connection_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());
  const auto answer = co_await ask(CommandCode::GetSystemStatus, "the tracker hides its status");
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
  const auto answer = co_await ask(CommandCode::GetSearchParams, "the tracker hides its search");
  if (!answer) co_return std::unexpected(answer.error());
  const SearchParams wanted{radius_mm, static_cast<std::int32_t>(options_.search_timeout.count())};
  if (std::get<SearchParams>(answer->body) == wanted) co_return TrackerResult<void>{};
  Command change{CommandCode::SetSearchParams, wanted};
  const auto set = co_await accepted(std::move(change), "the tracker refuses the search radius");
  if (!set) co_return std::unexpected(set.error());
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconTracker::Session::aim(Eigen::Vector3d p_W_mm, double search_radius_mm) {
  const auto begun = co_await begin();
  if (!begun) co_return std::unexpected(begun.error());
  const auto set = co_await set_search(search_radius_mm);
  if (!set) co_return std::unexpected(set.error());

  const Command steps[] = {
      {CommandCode::GoPosition, Position{{p_W_mm.x(), p_W_mm.y(), p_W_mm.z()}, true}},
      {CommandCode::FindReflector, SearchDistance{p_W_mm.norm()}},
  };
  for (const Command& step : steps) {
    Command command = step;
    const auto answer = co_await connection_.call(std::move(command));
    if (!answer) co_return std::unexpected(answer.error());
    if (answer->status == status::kAllOk) continue;
    TrackerError error = refusal("no reflector was found where the tracker looked", answer->status);
    // The number of a failed search is not public: what has no other meaning is one.
    if (error.fault == TrackerFault::Refused && !status::is_bad_parameter(answer->status)) {
      error.fault = TrackerFault::NoTarget;
    }
    co_return std::unexpected(error);
  }
  const auto locked = co_await is_locked();
  if (!locked) co_return std::unexpected(locked.error());
  if (!*locked) {
    co_return std::unexpected(
        TrackerError{TrackerFault::NoTarget, "the search ended without a locked reflector"});
  }
  co_return TrackerResult<void>{};
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
      if (change->event == SystemEvent::MeasurementNotReady) {
        co_return std::unexpected(beam_broken("the tracker is no longer ready to measure (event 25)"));
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
  if (auto why_not = implausible(result->point))
    co_return std::unexpected(TrackerError{TrackerFault::Refused, *std::move(why_not)});
  if (settings_in_doubt_) {
    co_return std::unexpected(TrackerError{
        TrackerFault::NotReady, "another program changed the tracker's settings during the measurement"});
  }
  co_return result->point;
}

EmsconTracker::EmsconTracker(asio::any_io_executor executor, Clock& clock, EmsconOptions options)
    : session_{std::make_unique<Session>(std::move(executor), clock, std::move(options))} {}

EmsconTracker::~EmsconTracker() = default;

asio::awaitable<std::expected<TrackerIdentity, TrackerError>> EmsconTracker::connect(TimePoint deadline) {
  auto connecting = session_->connect();
  auto identity = co_await before(session_->clock, deadline, std::move(connecting));
  const bool connected = identity && *identity;
  if (!connected) session_->close();
  if (!identity) co_return std::unexpected(late("was not connected and ready"));
  co_return *std::move(identity);
}

asio::awaitable<std::expected<TrackerIdentity, TrackerError>> EmsconTracker::inspect(TimePoint deadline) {
  auto inspecting = session_->inspect();
  auto identity = co_await before(session_->clock, deadline, std::move(inspecting));
  session_->close();
  if (!identity) co_return std::unexpected(late("did not answer"));
  co_return *std::move(identity);
}

asio::awaitable<std::expected<void, TrackerError>> EmsconTracker::aim(Eigen::Vector3d p_W_mm,
                                                                      double search_radius_mm,
                                                                      TimePoint deadline) {
  auto aiming = session_->aim(p_W_mm, search_radius_mm);
  const auto aimed = co_await before(session_->clock, deadline, std::move(aiming));
  if (!aimed) co_return std::unexpected(late("found no reflector"));
  co_return *aimed;
}

asio::awaitable<std::expected<SmrPoint, TrackerError>> EmsconTracker::measure(TimePoint deadline) {
  auto measuring = session_->measure();
  const auto point = co_await before(session_->clock, deadline, std::move(measuring));
  if (!point) co_return std::unexpected(late("gave no measurement"));
  co_return *point;
}

asio::awaitable<std::expected<void, TrackerError>> EmsconTracker::check(TimePoint deadline) {
  auto checking = session_->check();
  const auto checked = co_await before(session_->clock, deadline, std::move(checking));
  if (!checked) co_return std::unexpected(late("did not say how it is"));
  co_return *checked;
}

void EmsconTracker::disconnect() noexcept { session_->close(); }

}  // namespace truepose::drivers
