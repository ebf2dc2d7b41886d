#include "tools/sim/tracker/bridge_server.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/math/units.hpp"
#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"
#include "tools/sim/tracker/simulated_tracker.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using namespace bridge;

namespace {

constexpr const char* kBridgedSerialNumber = "390793";

std::string turned_away() {
  return encode_refusal(std::nullopt, Refusal::of(ErrorCode::Busy, "another program is connected")) + "\n";
}

bool is_known(std::string_view reflector) {
  return std::ranges::find(kReflectorBalls, reflector, &ReflectorBall::name) != kReflectorBalls.end();
}

class BridgeTracker final : public SimulatedTracker {
 public:
  BridgeTracker(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                TrackerServerOptions options)
      : SimulatedTracker{machine, target, std::move(noise), std::move(options), turned_away()} {}

 private:
  using Self = std::shared_ptr<BridgeTracker>;
  Self self() { return std::static_pointer_cast<BridgeTracker>(shared_from_this()); }

  // ---- The connection ----

  void connected() override {
    lines_ = control::LineSplitter{kMaxLine};
    greeted_ = false;
  }

  bool take(std::string_view bytes) override {
    lines_.push(bytes);
    while (const auto line = lines_.next()) {
      const auto asked = decode_request(*line);
      if (!asked) {
        tell(encode_refusal(asked.error().id, asked.error().refusal));
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

  void tell(std::string line) { send(std::move(line) + "\n"); }
  template <class Answer = Done>
  void answer(std::int64_t id, const Answer& answer = {}) {
    tell(encode_answer(id, answer));
  }
  void refuse(std::int64_t id, ErrorCode code, std::string text) {
    tell(encode_refusal(id, Refusal::of(code, std::move(text))));
  }
  void report(EventKind kind, std::string text = {}) {
    if (greeted_) tell(encode(Event::of(kind, std::move(text))));
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
    client_air_ = request.air;
    answer(id);
  }
  void handle(std::int64_t id, const Rehearse& request) {
    if (request.what == Rehearsal::WarmedUp) report(EventKind::WarmedUp);
    if (request.what == Rehearsal::BeamBreak) beam_break(request.lasts);
    answer(id);
  }
  void handle(std::int64_t id, const Initialise&) {
    if (may_act(id)) spawn(initialise(self(), begin(id)));
  }
  void handle(std::int64_t id, const DoAim& request) {
    if (may_move(id)) spawn(aim(self(), begin(id), request));
  }
  void handle(std::int64_t id, const SetFace& request) {
    if (may_measure(id)) spawn(turn(self(), begin(id), request.face));
  }
  void handle(std::int64_t id, const DoMeasure& request) {
    if (may_measure(id)) spawn(measure(self(), begin(id), request.time));
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
  void drop_job() override {
    pending_.reset();
    SimulatedTracker::drop_job();
  }
  /// @return the request that was under way
  std::int64_t end() {
    const std::int64_t id = *pending_;
    drop_job();
    return id;
  }

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
                          .orientation = self->orientation(),
                          .averaged = time,
                          .air = self->air()};
    self->answer(self->end(), result);
  }

  std::optional<Orientation> orientation() const {
    if (!options_.orientation_noise) return std::nullopt;
    const auto measured = beam_.orientation(options_.orientation_noise);
    if (!measured) return std::nullopt;
    const Eigen::Quaterniond turned{measured->R_WT};
    return Orientation{turned.w(), turned.x(), turned.y(), turned.z(), measured->sigma_rad * kDegPerRad};
  }
  /// By which it corrects distances.
  Air air() const { return client_air_.value_or(beam_.disturbance().station_air()); }

  // ---- What comes about by itself ----

  void lock_is_lost() override {
    report(EventKind::BeamLost);
    if (measuring_) refuse(end(), ErrorCode::BeamBroken, "the beam was broken");
  }
  void lock_is_found() override { report(EventKind::BeamFound); }
  void look_after() override {
    if (beam_.disturbance().storms) report(EventKind::Ready);
  }
  void forget() override { client_air_.reset(); }

  control::LineSplitter lines_{kMaxLine};
  bool greeted_ = false;
  std::optional<std::int64_t> pending_;  ///< the request that is under way
  std::string reflector_{kReflectorBalls.front().name};
  std::optional<Air> client_air_;
  double search_mm_ = 0;  ///< of the last aim
};

}  // namespace

BridgeServer::BridgeServer(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                           TrackerServerOptions options)
    : TrackerServer{std::make_shared<BridgeTracker>(machine, target, std::move(noise), std::move(options))} {}

}  // namespace truepose::sim
