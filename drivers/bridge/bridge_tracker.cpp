#include "drivers/bridge/bridge_tracker.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "core/math/units.hpp"
#include "core/planted_bug.hpp"
#include "drivers/bridge/bridge_connection.hpp"
#include "drivers/initialise_again.hpp"
#include "drivers/plausible_point.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using bridge::EventKind;

namespace {

// In which a bridge answers at most: what it only has to look up, and what moves the tracker.
constexpr Duration kLookUp = 3s;
constexpr Duration kMotion = 60s;
constexpr Duration kInitialise = 120s;
/// Older results are of another measurement.
constexpr std::chrono::milliseconds kFresh = 1s;
constexpr const char* kClient = "truepose";

std::optional<TrackerError> trouble(const bridge::Status& status) {
  if (status.state != bridge::State::NotReady && status.state != bridge::State::WarmingUp)
    return std::nullopt;
  return TrackerError{TrackerFault::NotReady, "the tracker is not ready: " + status.why};
}

/// What cannot be an answer to a measurement of this length.
std::optional<TrackerError> contradiction(const bridge::Measured& result, std::chrono::milliseconds asked) {
  const auto ms = [](std::chrono::milliseconds time) { return std::to_string(time.count()) + " ms"; };
  if (result.age > kFresh)
    return TrackerError{TrackerFault::Refused, "the bridge answered with a measurement that had ended " +
                                                   ms(result.age) + " before"};
  if (result.averaged < asked)
    return TrackerError{TrackerFault::Refused,
                        "the bridge averaged over " + ms(result.averaged) + ", asked for were " + ms(asked)};
  return std::nullopt;
}

/// "A, B"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

}  // namespace

SmrPoint point_of(const bridge::Measured& result) {
  SmrPoint point{.p_WS_mm = result.p_W_mm,
                 .std_mm = result.deviations_mm(),
                 .orientation = std::nullopt,
                 .temperature_c = result.air.temperature_c,
                 .pressure_mbar = result.air.pressure_mbar,
                 .humidity_percent = result.air.humidity_percent};
  if (const auto& turned = result.orientation)
    point.orientation = {turned->rotation(), turned->std_deg * kRadPerDeg};
  return point;
}

/// The dialogue with one bridge, without deadlines.
class BridgeTracker::Session final : public TrackerDialogue {
 public:
  Session(asio::any_io_executor executor, Clock& clock, BridgeOptions options)
      : options_{std::move(options)},
        time_{options_.measure},
        warm_up_{clock, options_.initialise_again},
        connection_{options_.stream(std::move(executor)), clock,
                    [this](const bridge::Event& event) { observe(event); }, options_.tap} {}

  TrackerTask<TrackerIdentity> connect() override;
  TrackerTask<TrackerIdentity> inspect() override;
  TrackerTask<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm) override;
  TrackerTask<SmrPoint> measure() override;
  TrackerTask<void> turn_over() override;
  TrackerTask<void> check() override;
  void average_over(Duration time) override { time_ = std::chrono::ceil<std::chrono::milliseconds>(time); }
  void close() noexcept override { connection_.close(); }

 private:
  void observe(const bridge::Event& event);
  TrackerTask<TrackerIdentity> greet();
  TrackerTask<bridge::Status> status();
  TrackerTask<bridge::Status> initialised();
  TrackerResult<std::string> reflector_among(const std::vector<std::string>& known) const;
  TrackerTask<void> end_unfinished();
  TrackerTask<void> ensure_settings();
  TrackerTask<bridge::Status> begin();
  TrackerTask<bridge::Status> begin_locked();

  const BridgeOptions options_;
  std::chrono::milliseconds time_;  ///< that each measurement averages over
  InitialiseAgain warm_up_;
  BridgeConnection connection_;
  std::string reflector_;         ///< that was chosen
  std::optional<Air> sent_air_;   ///< that was sent last
  bool settings_unknown_ = true;  ///< another client may have changed its settings
  bool unfinished_ = false;       ///< something was begun, and its end has not been seen
};

void BridgeTracker::Session::observe(const bridge::Event& event) {
  const auto kind = event.kind();
  if (kind == EventKind::SettingsChanged) settings_unknown_ = true;
  if (kind == EventKind::WarmedUp) warm_up_.has_warmed_up();
}

TrackerTask<TrackerIdentity> BridgeTracker::Session::greet() {
  settings_unknown_ = true;
  unfinished_ = false;
  sent_air_.reset();
  const auto opened = co_await connection_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());
  bridge::Hello hello{.client = kClient};
  const auto greeting = co_await connection_.ask(std::move(hello), "the bridge does not greet", kLookUp);
  if (!greeting) co_return std::unexpected(greeting.error());
  if (greeting->protocol != bridge::kProtocol) {
    connection_.close();
    co_return std::unexpected(TrackerError{
        TrackerFault::Protocol, "the bridge speaks version " + std::to_string(greeting->protocol) +
                                    " of the protocol, this truepose " + std::to_string(bridge::kProtocol)});
  }
  TrackerIdentity identity{greeting->model, greeting->serial, greeting->firmware};
  co_return identity;
}

TrackerTask<bridge::Status> BridgeTracker::Session::status() {
  bridge::GetStatus request;
  auto answer = co_await connection_.ask(request, "the bridge hides the tracker's status", kLookUp);
  co_return answer;
}

TrackerTask<bridge::Status> BridgeTracker::Session::initialised() {
  const auto found = co_await status();
  if (!found) co_return found;
  if (!found->initialised) warm_up_.found_cold();
  if (found->initialised && !warm_up_.is_due()) co_return found;
  bridge::Initialise request;
  const auto done = co_await connection_.ask(request, "the tracker cannot be initialised", kInitialise);
  if (!done) co_return std::unexpected(done.error());
  warm_up_.done();
  auto after_it = co_await status();
  co_return after_it;
}

TrackerResult<std::string> BridgeTracker::Session::reflector_among(
    const std::vector<std::string>& known) const {
  if (known.empty())
    return std::unexpected(TrackerError{
        TrackerFault::Refused, "the tracker lists no reflectors: define one with the maker's software"});
  if (options_.reflector.empty()) return known.front();
  if (std::ranges::find(known, options_.reflector) != known.end()) return options_.reflector;
  return std::unexpected(
      TrackerError{TrackerFault::Refused,
                   "the tracker knows no reflector \"" + options_.reflector + "\", only: " + listed(known)});
}

TrackerTask<TrackerIdentity> BridgeTracker::Session::connect() {
  auto identity = co_await greet();
  if (!identity) co_return identity;
  const auto status = co_await initialised();
  if (!status) co_return std::unexpected(status.error());
  if (auto why = trouble(*status)) co_return std::unexpected(*std::move(why));
  auto reflector = reflector_among(status->reflectors);
  if (!reflector) co_return std::unexpected(reflector.error());
  reflector_ = *std::move(reflector);
  const auto ensured = co_await ensure_settings();
  if (!ensured) co_return std::unexpected(ensured.error());
  co_return identity;
}

TrackerTask<TrackerIdentity> BridgeTracker::Session::inspect() {
  auto identity = co_await greet();
  if (!identity) co_return identity;
  const auto found = co_await status();
  if (!found) co_return std::unexpected(found.error());
  if (auto why = trouble(*found); why && found->initialised) co_return std::unexpected(*std::move(why));
  const auto reflector = reflector_among(found->reflectors);
  if (!reflector) co_return std::unexpected(reflector.error());
  co_return identity;
}

TrackerTask<void> BridgeTracker::Session::check() {
  const auto found = co_await status();
  if (!found) co_return std::unexpected(found.error());
  if (auto why = trouble(*found)) co_return std::unexpected(*std::move(why));
  co_return TrackerResult<void>{};
}

/// What was left in its midst is stopped first, lest it disturbs what follows.
TrackerTask<void> BridgeTracker::Session::end_unfinished() {
  if (!unfinished_ || planted("an interrupted request of a bridge is not stopped"))
    co_return TrackerResult<void>{};
  bridge::Stop stop;
  const auto stopped = co_await connection_.ask(stop, "the tracker does not stop", kLookUp);
  if (!stopped) co_return std::unexpected(stopped.error());
  unfinished_ = false;
  co_return TrackerResult<void>{};
}

/// Writes reflector and air where they may not be what they are to be.
TrackerTask<void> BridgeTracker::Session::ensure_settings() {
  if (settings_unknown_) {
    settings_unknown_ = false;
    sent_air_.reset();
    bridge::SetReflector choice{reflector_};
    const auto chosen =
        co_await connection_.ask(std::move(choice), "the tracker refuses its reflector", kLookUp);
    if (!chosen) settings_unknown_ = true;
    if (!chosen) co_return std::unexpected(chosen.error());
  }
  if (!options_.air) co_return TrackerResult<void>{};
  const auto air = options_.air();
  if (!air) co_return std::unexpected(TrackerError{TrackerFault::NotReady, air.error()});
  if (sent_air_ == *air) co_return TrackerResult<void>{};
  bridge::SetAir request{*air};
  const auto written = co_await connection_.ask(request, "the tracker refuses its air", kLookUp);
  if (!written) co_return std::unexpected(written.error());
  sent_air_ = *air;
  co_return TrackerResult<void>{};
}

/// What every operation starts with. The question for the status doubles as a barrier: the events of what
/// happened before it have been read when it is answered.
TrackerTask<bridge::Status> BridgeTracker::Session::begin() {
  const auto ended = co_await end_unfinished();
  if (!ended) co_return std::unexpected(ended.error());
  auto found = co_await status();
  if (!found) co_return found;
  if (planted("the status of a bridge is ignored")) found->locked = true, found->face = 0;
  if (found->reflector != reflector_) settings_unknown_ = true;
  const auto ensured = co_await ensure_settings();
  if (!ensured) co_return std::unexpected(ensured.error());
  co_return found;
}

TrackerTask<bridge::Status> BridgeTracker::Session::begin_locked() {
  auto begun = co_await begin();
  if (begun && !begun->locked)
    co_return std::unexpected(TrackerError{TrackerFault::NoTarget, "no reflector is locked"});
  co_return begun;
}

TrackerTask<void> BridgeTracker::Session::aim(Eigen::Vector3d p_W_mm, double search_radius_mm) {
  const auto begun = co_await begin();
  if (!begun) co_return std::unexpected(begun.error());
  if (warm_up_.warmed_up()) co_return std::unexpected(InitialiseAgain::refusal());
  unfinished_ = true;
  bridge::DoAim request{p_W_mm, search_radius_mm, options_.search_timeout};
  const auto aimed =
      co_await connection_.ask(request, "no reflector was found where the tracker looked", kMotion);
  unfinished_ = false;
  if (!aimed) co_return std::unexpected(aimed.error());
  co_return TrackerResult<void>{};
}

TrackerTask<void> BridgeTracker::Session::turn_over() {
  const auto begun = co_await begin_locked();
  if (!begun) co_return std::unexpected(begun.error());
  unfinished_ = true;
  bridge::SetFace request{begun->face == 2 ? 1 : 2};
  const auto turned = co_await connection_.ask(request, "the tracker does not turn over", kMotion);
  unfinished_ = false;
  if (!turned) co_return std::unexpected(turned.error());
  co_return TrackerResult<void>{};
}

TrackerTask<SmrPoint> BridgeTracker::Session::measure() {
  const auto begun = co_await begin_locked();
  if (!begun) co_return std::unexpected(begun.error());
  BridgeConnection::Ends ends = [](const bridge::Event& event) -> std::optional<TrackerError> {
    if (event.kind() != EventKind::BeamLost) return std::nullopt;
    return TrackerError{TrackerFault::BeamBroken, "the beam was broken during the measurement"};
  };
  const std::chrono::milliseconds asked = time_;
  unfinished_ = true;
  bridge::DoMeasure request{asked};
  const auto result =
      co_await connection_.ask(request, "the measurement failed", asked + kMotion, std::move(ends));
  // One that an event ended goes on in the bridge until it is stopped.
  const bool was_left = !result && result.error().fault == TrackerFault::BeamBroken;
  unfinished_ = was_left;
  if (!result) co_return std::unexpected(result.error());
  if (auto why_not = contradiction(*result, asked)) co_return std::unexpected(*std::move(why_not));
  const SmrPoint point = point_of(*result);
  if (auto why_not = implausible(point))
    co_return std::unexpected(TrackerError{TrackerFault::Refused, *std::move(why_not)});
  if (settings_unknown_)
    co_return std::unexpected(TrackerError{
        TrackerFault::NotReady, "another program changed the tracker's settings during the measurement"});
  co_return point;
}

BridgeTracker::BridgeTracker(asio::any_io_executor executor, Clock& clock, BridgeOptions options)
    : TimedTracker{clock, std::make_unique<Session>(std::move(executor), clock, std::move(options))} {}

}  // namespace truepose::drivers
