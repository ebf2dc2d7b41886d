#include "tools/sim/tracker/emscon_server.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"
#include "proto/emscon/status.hpp"
#include "tools/sim/tracker/simulated_tracker.hpp"
#include "tools/sim/tracker/tracker_settings.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using namespace emscon;
using namespace std::chrono_literals;

namespace {

constexpr auto kReflectorPositionPeriod = 100ms;
constexpr std::int32_t kSerialNumber = 390793;
constexpr std::int32_t kAt401 = 70;

std::string encode_any(const TrackerPacket& packet) {
  return std::visit(
      []<class T>(const T& alternative) {
        if constexpr (std::same_as<T, Unknown>) {
          return std::string{};
        } else {
          const std::vector<std::uint8_t> bytes = encode(alternative);
          return std::string{bytes.begin(), bytes.end()};
        }
      },
      packet);
}

class EmsconTracker final : public SimulatedTracker {
 public:
  EmsconTracker(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                TrackerServerOptions options)
      : SimulatedTracker{machine, target, std::move(noise), std::move(options),
                         encode_any(ErrorReport{CommandCode::Unknown, status::kSecondConnectionRefused})} {}

 private:
  using Self = std::shared_ptr<EmsconTracker>;
  Self self() { return std::static_pointer_cast<EmsconTracker>(shared_from_this()); }

  // ---- Connections ----

  void connected() override { splitter_ = {}; }

  /// @return false when the stream is not emScon
  bool take(std::string_view received) override {
    splitter_.push({reinterpret_cast<const std::uint8_t*>(received.data()), received.size()});
    for (;;) {
      const auto bytes = splitter_.next();
      if (!bytes) return false;
      if (!*bytes) return true;
      const auto packet = decode_client_packet(**bytes);
      if (!packet) return false;
      if (const auto* command = std::get_if<Command>(&*packet)) handle(*command);
    }
  }

  void tell(const TrackerPacket& packet) { send(encode_any(packet)); }
  void answer(CommandCode code, std::int32_t status, Body body = {}) {
    tell(Answer{code, status, std::move(body)});
  }
  void report(SystemEvent event) { tell(SystemStatusChange{event}); }

  // ---- Commands ----

  void handle(const Command& command) {
    if (command.code == CommandCode::StopMeasurement) return stop(command.code);
    if (jobs_.busy() || beam_.disturbance().busy) return answer(command.code, status::kServerBusy);
    if (const auto packets = settings_.handle(command)) {
      for (const TrackerPacket& packet : *packets) tell(packet);
    } else if (auto state = known_state(command.code)) {
      answer(command.code, status::kAllOk, *std::move(state));
    } else if (command.code == CommandCode::StartNivelMeasurement) {
      answer(command.code, status::kNotImplemented);
    } else if (command.code == CommandCode::ExitApplication) {
      port_->send_and_close(encode_any(Answer{command.code, status::kAllOk, {}}));
    } else if (command.code == CommandCode::Initialize) {
      spawn(initialize(self(), jobs_.begin()));
    } else if (!initialised_) {
      answer(command.code, status::kNotInitialized);
    } else {
      point_or_measure(command);
    }
  }

  /// What a tracker can say of itself before it is initialised.
  std::optional<Body> known_state(CommandCode code) const {
    switch (code) {
      case CommandCode::GetSystemStatus:
        return system_status();
      case CommandCode::GetTrackerStatus:
        return TrackerStatus{readiness()};
      case CommandCode::GetMeasurementStatusInfo:
        return MeasurementStatusInfo{0, status_mask()};
      case CommandCode::GetTrackerInfo:
        return TrackerInfo{kAt401, "truepose simulated tracker"};
      case CommandCode::GetAt4xxInfo:
        return at4xx_info();
      case CommandCode::GetSystemSoftwareVersion:
        return SoftwareVersion{"3.8.900 (simulated)"};
      case CommandCode::GetFace:
        return FaceAnswer{beam_.face()};
      case CommandCode::GetObjectTemperature:
        return ObjectTemperature{settings_.from_metric(beam_.disturbance().station_air()).temperature};
      case CommandCode::ClearCommandQueue:
        return Body{};
      default:
        return std::nullopt;
    }
  }

  void point_or_measure(const Command& command) {
    switch (command.code) {
      case CommandCode::GetDirection:
        return answer(command.code, status::kAllOk, direction());
      case CommandCode::ReleaseMotors:
      case CommandCode::Park:
      case CommandCode::MoveHv:
        lose_lock();
        return answer(command.code, status::kAllOk);
      case CommandCode::GoBirdBath:
      case CommandCode::GoBirdBath2:
        return spawn(go_home(self(), jobs_.begin(), command.code));
      case CommandCode::ChangeFace:
        return spawn(turn_over(self(), jobs_.begin()));
      case CommandCode::CheckBirdBath:
        return answer(command.code, status::kAllOk, BirdBathCheck{});
      case CommandCode::GoPosition:
        return go(command.code, settings_.to_mm(std::get<Position>(command.body).v));
      case CommandCode::GoPositionHvd:
        return go(command.code, settings_.hvd_to_mm(std::get<Position>(command.body).v));
      case CommandCode::PointLaser:
        return go(command.code, settings_.to_mm(std::get<Aim>(command.body).v));
      case CommandCode::PointLaserHvd:
        return go(command.code, settings_.hvd_to_mm(std::get<Aim>(command.body).v));
      case CommandCode::PositionRelativeHv:
        return go(command.code, turned(std::get<Direction>(command.body)));
      case CommandCode::GoLastMeasuredPoint:
        if (!last_measured_mm_) return answer(command.code, status::kNoLastMeasuredPoint);
        return go(command.code, *last_measured_mm_);
      case CommandCode::LookForTarget:
        return look_for(std::get<TargetSearch>(command.body));
      case CommandCode::GoAndMeasure:
        return spawn(go_and_measure(self(), jobs_.begin(), settings_.to_mm(std::get<Aim>(command.body).v)));
      case CommandCode::FindReflector:
        return spawn(search(self(), jobs_.begin()));
      case CommandCode::StartMeasurement:
        if (!beam_.locked()) return answer(command.code, status::kSystemNotReady);
        answer(command.code, status::kAllOk);
        return spawn(measure(self(), jobs_.begin()));
      default:
        return answer(command.code, status::kUnknown);
    }
  }

  void go(CommandCode code, const Eigen::Vector3d& aim_mm) {
    spawn(drive(self(), jobs_.begin(), code, aim_mm));
  }

  void look_for(const TargetSearch& search) {
    const auto found = beam_.find(settings_.to_mm(search.v), settings_.length_to_mm(search.radius));
    if (!found) return answer(CommandCode::LookForTarget, kSimulatedNoTarget);
    answer(CommandCode::LookForTarget, status::kAllOk, direction_to(*found));
  }

  At4xxInfo at4xx_info() const {
    return {.min_measure_ms = 500,
            .min_distance = settings_.from_mm(1'500),
            .max_distance = settings_.from_mm(160'000),
            .adm_offset_std = settings_.from_mm(0.01),
            .angle_std_constant = settings_.from_mm(0.0075),
            .angle_std_offset = 0,
            .angle_std_factor = 3e-6};
  }

  void stop(CommandCode code) {
    const bool measured = measuring_;
    if (measured) drop_job();
    answer(code, status::kAllOk);
    if (measured && beam_.locked()) report(SystemEvent::MeasurementReady);
  }

  SystemStatus system_status() const {
    return {.processor = initialised_ ? ProcessorStatus::Initialized : ProcessorStatus::CompensationSet,
            .laser = LaserStatus::Ready,
            .adm = AdmStatus::Ready,
            .server_version = {3, 8, 900},
            .weather = options_.instrument.weather_station ? WeatherMonitor::ReadAndCompute
                                                           : WeatherMonitor::NotConnected,
            .serial_number = kSerialNumber};
  }
  TrackerReadiness readiness() const {
    return beam_.locked() ? TrackerReadiness::Ready : TrackerReadiness::NotReady;
  }
  std::int32_t status_mask() const {
    return kTrackerFoundBit | (initialised_ ? kInitializedBit : 0) |
           (beam_.locked() ? kReflectorFoundBit : 0);
  }
  Direction direction() const { return direction_to(beam_.aim_mm()); }
  Direction direction_to(const Eigen::Vector3d& p_mm) const {
    const Eigen::Vector3d hvd = in_system(CoordinateSystem::Scc, p_mm);
    return {settings_.from_rad(hvd[0]), settings_.from_rad(hvd[1])};
  }
  Eigen::Vector3d turned(const Direction& by) const {
    Eigen::Vector3d hvd = in_system(CoordinateSystem::Scc, beam_.aim_mm());
    hvd[0] += settings_.to_rad(by.horizontal);
    hvd[1] += settings_.to_rad(by.vertical);
    return out_of_system(CoordinateSystem::Scc, hvd);
  }

  // ---- Commands that take time ----

  void end_job(CommandCode code, std::int32_t status) {
    drop_job();
    answer(code, status);
  }

  static asio::awaitable<void> initialize(Self self, Job job) {
    self->lose_lock();
    const bool going_on = co_await self->jobs_.wait(job, kInitializeTime);
    if (!going_on) co_return;
    self->initialised_ = true;
    self->beam_.come_home();  // as an AT40x does, locked
    self->end_job(CommandCode::Initialize, status::kAllOk);
    self->report(SystemEvent::InitializationChanged);
    self->report(SystemEvent::MeasurementReady);
  }

  static asio::awaitable<void> go_home(Self self, Job job, CommandCode code) {
    self->lose_lock();
    const bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    self->beam_.come_home();
    self->end_job(code, status::kAllOk);
    self->report(SystemEvent::MeasurementReady);
  }

  static asio::awaitable<void> drive(Self self, Job job, CommandCode code, Eigen::Vector3d aim_mm) {
    self->lose_lock();
    const bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    self->beam_.point_at(aim_mm);
    self->end_job(code, status::kAllOk);
  }

  /// Comes to point where it did, with no reflector locked.
  static asio::awaitable<void> turn_over(Self self, Job job) {
    self->lose_lock();
    const bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    self->beam_.turn_over();
    self->end_job(CommandCode::ChangeFace, status::kAllOk);
  }

  /// Drives, locks within the search radius, measures. Its answer says that the measurement has begun.
  static asio::awaitable<void> go_and_measure(Self self, Job job, Eigen::Vector3d aim_mm) {
    self->lose_lock();
    const bool going_on = co_await self->jobs_.wait(job, kDriveTime);
    if (!going_on) co_return;
    self->beam_.point_at(aim_mm);
    self->lock();
    if (!self->beam_.locked()) co_return self->end_job(CommandCode::GoAndMeasure, kSimulatedNoTarget);
    self->answer(CommandCode::GoAndMeasure, status::kAllOk);
    co_await measure(self, job);
  }

  static asio::awaitable<void> search(Self self, Job job) {
    const auto timeout = std::chrono::duration_cast<drivers::Duration>(
        std::chrono::duration<double, std::milli>{self->settings_.search_timeout_ms()});
    bool going_on = co_await self->jobs_.wait(job, std::min<drivers::Duration>(kSearchTime, timeout));
    if (!going_on) co_return;
    self->lock();
    if (!self->beam_.locked()) {
      going_on = co_await self->jobs_.wait(job, timeout);
      if (going_on) self->end_job(CommandCode::FindReflector, kSimulatedNoTarget);
      co_return;
    }
    self->end_job(CommandCode::FindReflector, status::kAllOk);
    self->report(SystemEvent::MeasurementReady);
  }

  static asio::awaitable<void> measure(Self self, Job job) {
    self->report(SystemEvent::MeasurementBusy);
    self->measuring_ = true;
    self->options_.before_point(self->measurements_ + 1);
    const auto between = std::chrono::duration_cast<drivers::Duration>(
        std::chrono::duration<double, std::milli>{self->settings_.measure_ms() / kReadings});
    std::vector<Eigen::Vector3d> readings_mm;
    for (int i = 0; i < kReadings; ++i) {
      const bool going_on = co_await self->jobs_.wait(job, between);
      if (!going_on) co_return;
      self->follow();
      if (!self->jobs_.is_current(job)) co_return;  // the beam broke and ended this measurement
      readings_mm.push_back(self->beam_.reading(self->index_taken()));
    }
    self->drop_job();
    ++self->measurements_;
    self->send_result(MeanReading::of(readings_mm));
    self->report(SystemEvent::MeasurementReady);
  }

  void send_result(const MeanReading& mean) {
    last_measured_mm_ = mean.p_mm;
    const auto fill = [&](auto result) {
      result.v = settings_.point(mean.p_mm);
      result.std = settings_.deviations(mean.p_mm, mean.std_mm);
      result.std_total = settings_.from_mm(mean.std_mm.norm());
      if (const auto& std_mm = beam_.disturbance().std_mm) {
        result.std_total = settings_.from_mm(*std_mm);
        result.std.fill(result.std_total);
      }
      result.environment =
          by_station() ? settings_.from_metric(beam_.disturbance().station_air()) : settings_.environment();
      tell(result);
    };
    if (settings_.extended_statistics()) return fill(SingleMeasResult2{});
    fill(SingleMeasResult{});
  }

  bool by_station() const { return options_.instrument.weather_station && settings_.computes_refraction(); }
  /// The refraction by which it corrects distances.
  double index_taken() const {
    return by_station() ? edlen_group_index(beam_.disturbance().station_air()) : settings_.adm_index();
  }

  // ---- The beam ----

  /// Locks to the reflector that is seen within the search radius of where the beam points.
  void lock() { beam_.lock_within(settings_.search_radius_mm()); }

  bool power_lock() const override { return options_.power_lock || settings_.power_lock(); }
  void lock_is_found() override { report(SystemEvent::MeasurementReady); }

  void lose_lock() {
    if (!beam_.locked()) return;
    beam_.release();
    lock_is_lost();
  }

  void lock_is_lost() override {
    report(SystemEvent::MeasurementNotReady);
    if (!measuring_) return;
    drop_job();
    tell(ErrorReport{CommandCode::StartMeasurement, kSimulatedBeamBroken});
  }

  void storm() {
    constexpr int kAtOnce = 5;
    for (int i = 0; i < kAtOnce; ++i) report(SystemEvent::EnvironmentChanged);
  }

  void look_after() override {
    if (beam_.disturbance().storms) storm();
    const bool due = machine_.clock.now() - last_position_ >= kReflectorPositionPeriod;
    if (!beam_.locked() || !due || !settings_.sends_reflector_position()) return;
    last_position_ = machine_.clock.now();
    tell(ReflectorPosResult{status::kAllOk, settings_.point(beam_.aim_mm())});
  }

  void forget() override { settings_ = {}; }

  PacketSplitter splitter_;
  TrackerSettings settings_;
  std::optional<Eigen::Vector3d> last_measured_mm_;
  drivers::TimePoint last_position_;
};

}  // namespace

EmsconServer::EmsconServer(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                           TrackerServerOptions options)
    : TrackerServer{std::make_shared<EmsconTracker>(machine, target, std::move(noise), std::move(options))} {}

}  // namespace truepose::sim
