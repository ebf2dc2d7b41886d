#include "tools/sim/bridge_server.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"
#include "tools/sim/one_client_port.hpp"
#include "tools/sim/tracker_jobs.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using namespace bridge;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBridgedSerialNumber = "390793";

std::string turned_away() {
  return encode_refusal(std::nullopt, Refusal::of(ErrorCode::Busy, "another program is connected")) + "\n";
}

bool is_known(std::string_view reflector) {
  return std::ranges::find(kReflectorBalls, reflector, &ReflectorBall::name) != kReflectorBalls.end();
}

}  // namespace

/// Shared with the coroutines; after close() none of them touches the target any more.
class BridgeServer::State : public std::enable_shared_from_this<State> {
 public:
  State(asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
        TrackerServerOptions options)
      : options_{std::move(options)},
        beam_{target, std::move(noise), options_.instrument, options_.speedup},
        executor_{executor},
        jobs_{executor, options_.speedup},
        watch_timer_{executor},
        port_{std::in_place,
              executor,
              options_.address,
              options_.port,
              turned_away(),
              PortListener{[this] { connected(); }, [this](std::string_view bytes) { return take(bytes); },
                           [this] { drop_job(); }}} {}

  void start() { spawn(watch(shared_from_this())); }

  void close() {
    closed_ = true;
    drop_job();
    port_.reset();
    watch_timer_.cancel();
  }

  std::uint16_t port() const { return port_->port(); }
  std::uint64_t measurements() const { return measurements_; }

  void disturb(const TrackerDisturbance& disturbance) { beam_.disturb(disturbance); }

  void beam_break(std::chrono::milliseconds duration) {
    beam_.block(duration);
    follow();
  }

  void restart() {
    drop_job();
    port_->drop();
    beam_.release();
    initialised_ = false;
    told_.reset();
  }

 private:
  using Self = std::shared_ptr<State>;
  using Job = TrackerJobs::Job;

  // ---- The connection ----

  void connected() {
    lines_ = control::LineSplitter{kMaxLine};
    greeted_ = false;
  }

  bool take(std::string_view bytes) {
    lines_.push(bytes);
    while (const auto line = lines_.next()) {
      const auto asked = decode_request(*line);
      if (!asked) {
        send(encode_refusal(asked.error().id, asked.error().refusal));
        continue;
      }
      if (!greeted_ && !std::holds_alternative<Hello>(asked->request)) {
        refuse(asked->id, ErrorCode::BadRequest, "say hello first");
        continue;
      }
      std::visit([this, id = asked->id](const auto& request) { handle(id, request); }, asked->request);
    }
    return !lines_.overflowed();
  }

  void send(std::string line) {
    if (beam_.disturbance().silent) return;
    port_->send(std::move(line) + "\n");
  }
  template <class Answer = Done>
  void answer(std::int64_t id, const Answer& answer = {}) {
    send(encode_answer(id, answer));
  }
  void refuse(std::int64_t id, ErrorCode code, std::string text) {
    send(encode_refusal(id, Refusal::of(code, std::move(text))));
  }
  void report(EventKind kind, std::string text = {}) {
    if (greeted_) send(encode(Event::of(kind, std::move(text))));
  }

  // ---- Requests ----

  void handle(std::int64_t id, const Hello&) {
    greeted_ = true;
    answer(id, Greeting{.bridge = "truepose-sim",
                        .model = "truepose simulated tracker",
                        .serial = kBridgedSerialNumber,
                        .firmware = "1.0",
                        .rehearses = {Rehearsal::BeamBreak, Rehearsal::WarmedUp}});
  }
  void handle(std::int64_t id, const Ping&) { answer(id); }
  void handle(std::int64_t id, const GetStatus&) {
    Status status{
        .state = jobs_.busy() || beam_.disturbance().busy ? bridge::State::Busy : bridge::State::Ready,
        .initialised = initialised_,
        .locked = beam_.locked(),
        .face = beam_.face(),
        .reflector = reflector_};
    if (!initialised_ && status.state == bridge::State::Ready) {
      status.state = bridge::State::NotReady;
      status.why = "it is not initialised";
    }
    for (const ReflectorBall& ball : kReflectorBalls) status.reflectors.emplace_back(ball.name);
    answer(id, status);
  }
  void handle(std::int64_t id, const Stop&) {
    if (pending_) refuse(*pending_, ErrorCode::Stopped, "stopped when asked to");
    drop_job();
    answer(id);
  }
  void handle(std::int64_t id, const SetReflector& request) {
    if (!may_act(id)) return;
    if (!is_known(request.name))
      return refuse(id, ErrorCode::UnknownReflector, "there is no reflector \"" + request.name + "\"");
    reflector_ = request.name;
    answer(id);
  }
  void handle(std::int64_t id, const SetAir& request) {
    if (!may_act(id)) return;
    told_ = request.air;
    answer(id);
  }
  void handle(std::int64_t id, const Rehearse& request) {
    if (request.what == Rehearsal::WarmedUp) report(EventKind::WarmedUp);
    if (request.what == Rehearsal::BeamBreak) beam_break(request.lasts);
    answer(id);
  }
  void handle(std::int64_t id, const Initialise&) {
    if (may_act(id)) spawn(initialise(shared_from_this(), begin(id)));
  }
  void handle(std::int64_t id, const DoAim& request) {
    if (may_move(id)) spawn(aim(shared_from_this(), begin(id), request));
  }
  void handle(std::int64_t id, const SetFace& request) {
    if (may_measure(id)) spawn(turn(shared_from_this(), begin(id), request.face));
  }
  void handle(std::int64_t id, const DoMeasure& request) {
    if (may_measure(id)) spawn(measure(shared_from_this(), begin(id), request.time));
  }

  // What stands against a request has been answered where these return false.

  bool may_act(std::int64_t id) {
    const bool busy = jobs_.busy() || beam_.disturbance().busy;
    if (busy) refuse(id, ErrorCode::Busy, "the tracker does something else");
    return !busy;
  }
  bool may_move(std::int64_t id) {
    if (!may_act(id)) return false;
    if (!initialised_) refuse(id, ErrorCode::NotInitialised, "the tracker is not initialised");
    return initialised_;
  }
  bool may_measure(std::int64_t id) {
    if (!may_move(id)) return false;
    if (!beam_.locked()) refuse(id, ErrorCode::NoTarget, "no reflector is locked");
    return beam_.locked();
  }

  // ---- What takes time ----

  Job begin(std::int64_t id) {
    pending_ = id;
    return jobs_.begin();
  }
  void drop_job() {
    pending_.reset();
    measuring_ = false;
    jobs_.drop();
  }
  /// @return the request that was under way
  std::int64_t end() {
    const std::int64_t id = *pending_;
    drop_job();
    return id;
  }
  void spawn(asio::awaitable<void> job) { asio::co_spawn(executor_, std::move(job), asio::detached); }

  static asio::awaitable<void> initialise(Self self, Job job) {
    self->beam_.release();
    const bool going_on = co_await self->jobs_.wait(job, kInitializeTime);
    if (!going_on) co_return;
    self->initialised_ = true;
    self->beam_.initialise();
    self->answer(self->end());
    self->report(EventKind::Ready);
  }

  static asio::awaitable<void> aim(Self self, Job job, DoAim request) {
    self->beam_.release();
    bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    if (self->beam_.face() != 1) self->beam_.turn_over();
    self->beam_.point_at(request.p_W_mm);
    self->search_mm_ = request.search_mm;
    going_on = co_await self->jobs_.wait(job, std::min<TrackerJobs::Duration>(kSearchTime, request.timeout));
    if (!going_on) co_return;
    if (!self->beam_.lock_within(request.search_mm)) {
      going_on = co_await self->jobs_.wait(job, request.timeout);
      if (going_on) self->refuse(self->end(), ErrorCode::NoTarget, "the search found no reflector");
      co_return;
    }
    self->answer(self->end());
    self->report(EventKind::BeamFound);
  }

  static asio::awaitable<void> turn(Self self, Job job, int face) {
    const bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    if (self->beam_.face() != face) self->beam_.turn_over();
    if (self->beam_.locked() || self->beam_.lock_within(self->search_mm_)) {
      self->answer(self->end());
    } else {
      self->refuse(self->end(), ErrorCode::NoTarget, "the reflector was not found from the other face");
    }
  }

  static asio::awaitable<void> measure(Self self, Job job, std::chrono::milliseconds time) {
    self->measuring_ = true;
    self->options_.before_point(self->measurements_ + 1);
    std::vector<Eigen::Vector3d> readings_mm;
    for (int i = 0; i < kReadings; ++i) {
      const bool going_on = co_await self->jobs_.wait(job, time / kReadings);
      if (!going_on) co_return;
      self->follow();
      if (!self->jobs_.is_current(job)) co_return;  // the beam broke and ended this measurement
      readings_mm.push_back(self->beam_.reading(edlen_group_index(self->air())));
    }
    ++self->measurements_;
    MeanReading mean = MeanReading::of(readings_mm);
    if (const auto& std_mm = self->beam_.disturbance().std_mm) mean.std_mm.fill(*std_mm);
    const Measured result{.p_W_mm = mean.p_mm,
                          .std_mm = mean.std_mm.cwiseMax(0),
                          .covariance_mm2 = {},
                          .averaged = time,
                          .air = self->air()};
    self->answer(self->end(), result);
  }

  /// By which it corrects distances.
  Air air() const { return told_.value_or(beam_.disturbance().station_air()); }

  // ---- The beam ----

  void follow() {
    if (!beam_.follow()) return;
    report(EventKind::BeamLost);
    if (measuring_) refuse(end(), ErrorCode::BeamBroken, "the beam was broken");
  }

  /// PowerLock finds a reflector by itself, wherever the beam points.
  void lock_by_itself() {
    if (beam_.locked() || jobs_.busy() || !initialised_ || !options_.power_lock) return;
    if (beam_.lock_within(std::numeric_limits<double>::infinity())) report(EventKind::BeamFound);
  }

  static asio::awaitable<void> watch(Self self) {
    const auto period = std::clamp<TrackerJobs::Duration>(self->jobs_.scaled(20ms), 1ms, 20ms);
    for (;;) {
      self->watch_timer_.expires_after(period);
      co_await self->watch_timer_.async_wait(asio::as_tuple(asio::use_awaitable));
      if (self->closed_) co_return;
      self->follow();
      self->lock_by_itself();
      if (self->beam_.disturbance().storms) self->report(EventKind::Ready);
    }
  }

  const TrackerServerOptions options_;
  TrackerBeam beam_;
  asio::any_io_executor executor_;
  TrackerJobs jobs_;
  asio::steady_timer watch_timer_;
  control::LineSplitter lines_{kMaxLine};
  bool closed_ = false;

  bool greeted_ = false;
  bool initialised_ = false;
  bool measuring_ = false;               ///< what is under way is a measurement
  std::optional<std::int64_t> pending_;  ///< the request that is under way
  std::string reflector_{kReflectorBalls.front().name};
  std::optional<Air> told_;
  double search_mm_ = 0;  ///< of the last aim
  std::uint64_t measurements_ = 0;
  std::optional<OneClientPort> port_;
};

BridgeServer::BridgeServer(asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
                           TrackerServerOptions options)
    : state_{std::make_shared<State>(std::move(executor), target, std::move(noise), std::move(options))} {
  state_->start();
}

BridgeServer::~BridgeServer() { state_->close(); }

std::uint16_t BridgeServer::port() const { return state_->port(); }
std::uint64_t BridgeServer::measurements() const { return state_->measurements(); }
void BridgeServer::disturb(const TrackerDisturbance& disturbance) { state_->disturb(disturbance); }
void BridgeServer::beam_break(std::chrono::milliseconds duration) { state_->beam_break(duration); }
void BridgeServer::restart() { state_->restart(); }

}  // namespace truepose::sim
