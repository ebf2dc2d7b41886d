#include "tools/sim/emscon_server.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"
#include "proto/emscon/status.hpp"
#include "tools/sim/tracker_settings.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using namespace emscon;
using namespace std::chrono_literals;

namespace {

constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
constexpr auto kInitializeTime = 20s;
constexpr auto kDriveTime = 1s;
constexpr auto kSearchTime = 500ms;
constexpr auto kReflectorPositionPeriod = 100ms;
constexpr int kReadings = 10;  ///< that one measurement averages
constexpr std::int32_t kSerialNumber = 390793;
constexpr std::int32_t kAt401 = 70;

std::vector<std::uint8_t> encode_any(const TrackerPacket& packet) {
  return std::visit(
      []<class T>(const T& alternative) {
        if constexpr (std::same_as<T, Unknown>) {
          return std::vector<std::uint8_t>{};
        } else {
          return encode(alternative);
        }
      },
      packet);
}

/// A connection with its queue of packets on the way out.
class Client : public std::enable_shared_from_this<Client> {
 public:
  explicit Client(tcp::socket socket) : socket_{std::move(socket)} {
    error_code ignored;
    socket_.set_option(tcp::no_delay{true}, ignored);
  }

  void send(const TrackerPacket& packet) {
    outgoing_.push_back(encode_any(packet));
    if (outgoing_.size() == 1) write_next();
  }

  /// Sends what is queued, then ends the connection once the peer has read it.
  void send_and_close(const TrackerPacket& packet) {
    closing_ = true;
    send(packet);
  }

  void close() {
    error_code ignored;
    socket_.close(ignored);
  }

  tcp::socket& socket() { return socket_; }

 private:
  void write_next() {
    asio::async_write(socket_, asio::buffer(outgoing_.front()),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (error) return self->outgoing_.clear();
                        self->outgoing_.pop_front();
                        if (!self->outgoing_.empty()) return self->write_next();
                        if (self->closing_) self->socket_.shutdown(tcp::socket::shutdown_send, error);
                        if (self->closing_) self->discard();
                      });
  }

  /// Reading on until the peer closes keeps a reset from overtaking the last packet.
  void discard() {
    socket_.async_read_some(asio::buffer(discarded_),
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (!error) self->discard();
                            });
  }

  tcp::socket socket_;
  std::deque<std::vector<std::uint8_t>> outgoing_;
  std::array<std::uint8_t, 256> discarded_{};
  bool closing_ = false;
};

}  // namespace

/// Shared with the coroutines; after close() none of them touches the target any more.
class EmsconServer::State : public std::enable_shared_from_this<State> {
 public:
  State(asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
        EmsconServerOptions options)
      : target_{target},
        noise_{std::move(noise)},
        options_{std::move(options)},
        acceptor_{executor, tcp::endpoint{asio::ip::make_address(options_.address), options_.port}},
        job_timer_{executor},
        watch_timer_{executor} {}

  void start() {
    asio::co_spawn(acceptor_.get_executor(), accept(shared_from_this()), asio::detached);
    asio::co_spawn(acceptor_.get_executor(), watch(shared_from_this()), asio::detached);
  }

  void close() {
    closed_ = true;
    drop_job();
    if (client_) client_->close();
    error_code ignored;
    acceptor_.close(ignored);
    watch_timer_.cancel();
  }

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  std::uint64_t measurements() const { return measurements_; }

  void disturb(const TrackerDisturbance& disturbance) { disturbance_ = disturbance; }

  void beam_break(std::chrono::milliseconds duration) {
    blocked_until_ = std::max(blocked_until_, Clock::now() + duration);
    update_lock();
  }

  void restart() {
    drop_job();
    if (client_) client_->close();
    client_.reset();
    initialized_ = locked_ = false;
    settings_ = {};
  }

 private:
  using Self = std::shared_ptr<State>;

  // ---- Connections ----

  static asio::awaitable<void> accept(Self self) {
    while (!self->closed_) {
      auto [error, socket] = co_await self->acceptor_.async_accept(kToResult);
      if (error) continue;
      const auto client = std::make_shared<Client>(std::move(socket));
      // A client that left and came back at once: let the end of its old connection be seen first.
      co_await asio::post(self->acceptor_.get_executor(), asio::use_awaitable);
      if (self->client_) {
        client->send_and_close(ErrorReport{CommandCode::Unknown, status::kSecondConnectionRefused});
        continue;
      }
      self->client_ = client;
      asio::co_spawn(self->acceptor_.get_executor(), serve(self, client), asio::detached);
    }
  }

  static asio::awaitable<void> serve(Self self, std::shared_ptr<Client> client) {
    PacketSplitter splitter;
    std::array<std::uint8_t, 4096> received{};
    for (bool good = true; good;) {
      auto [error, size] = co_await client->socket().async_read_some(asio::buffer(received), kToResult);
      if (error) break;
      splitter.push({received.data(), size});
      good = self->handle_all(splitter);
    }
    client->close();
    if (self->client_ != client) co_return;
    self->drop_job();
    self->client_.reset();
  }

  /// @return false when the stream is not emScon
  bool handle_all(PacketSplitter& splitter) {
    for (;;) {
      const auto bytes = splitter.next();
      if (!bytes) return false;
      if (!*bytes) return true;
      const auto packet = decode_client_packet(**bytes);
      if (!packet) return false;
      if (const auto* command = std::get_if<Command>(&*packet)) handle(*command);
    }
  }

  void send(const TrackerPacket& packet) {
    if (client_ && !disturbance_.silent) client_->send(packet);
  }
  void answer(CommandCode code, std::int32_t status, Body body = {}) {
    send(Answer{code, status, std::move(body)});
  }
  void report(SystemEvent event) { send(SystemStatusChange{event}); }

  // ---- Commands ----

  void handle(const Command& command) {
    if (command.code == CommandCode::StopMeasurement) return stop(command.code);
    if (job_ || disturbance_.busy) return answer(command.code, status::kServerBusy);
    if (const auto packets = settings_.handle(command)) {
      for (const TrackerPacket& packet : *packets) send(packet);
    } else if (auto state = known_state(command.code)) {
      answer(command.code, status::kAllOk, *std::move(state));
    } else if (command.code == CommandCode::StartNivelMeasurement) {
      answer(command.code, status::kNotImplemented);
    } else if (command.code == CommandCode::ExitApplication) {
      if (client_) client_->send_and_close(Answer{command.code, status::kAllOk, {}});
    } else if (command.code == CommandCode::Initialize) {
      spawn(initialize(shared_from_this(), begin_job()));
    } else if (!initialized_) {
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
        return FaceAnswer{face_};
      case CommandCode::GetObjectTemperature:
        return ObjectTemperature{settings_.from_metric(station_air()).temperature};
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
      case CommandCode::GoBirdBath:
      case CommandCode::GoBirdBath2:
      case CommandCode::MoveHv:
        lose_lock();
        return answer(command.code, status::kAllOk);
      case CommandCode::ChangeFace:
        return spawn(turn_over(shared_from_this(), begin_job()));
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
        return spawn(
            go_and_measure(shared_from_this(), begin_job(), settings_.to_mm(std::get<Aim>(command.body).v)));
      case CommandCode::FindReflector:
        return spawn(search(shared_from_this(), begin_job()));
      case CommandCode::StartMeasurement:
        if (!locked_) return answer(command.code, status::kSystemNotReady);
        answer(command.code, status::kAllOk);
        return spawn(measure(shared_from_this(), begin_job()));
      default:
        return answer(command.code, status::kUnknown);
    }
  }

  void go(CommandCode code, const Eigen::Vector3d& aim_mm) {
    spawn(drive(shared_from_this(), begin_job(), code, aim_mm));
  }

  void look_for(const TargetSearch& search) {
    const auto found = nearest_to(settings_.to_mm(search.v), settings_.length_to_mm(search.radius));
    if (!found) return answer(CommandCode::LookForTarget, kSimulatedNoTarget);
    answer(CommandCode::LookForTarget, status::kAllOk, direction_to(*seen(*found)));
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
    if (measured && locked_) report(SystemEvent::MeasurementReady);
  }

  SystemStatus system_status() const {
    return {.processor = initialized_ ? ProcessorStatus::Initialized : ProcessorStatus::CompensationSet,
            .laser = LaserStatus::Ready,
            .adm = AdmStatus::Ready,
            .server_version = {3, 8, 900},
            .weather = options_.instrument.weather_station ? WeatherMonitor::ReadAndCompute
                                                           : WeatherMonitor::NotConnected,
            .serial_number = kSerialNumber};
  }
  TrackerReadiness readiness() const {
    return locked_ ? TrackerReadiness::Ready : TrackerReadiness::NotReady;
  }
  std::int32_t status_mask() const {
    return kTrackerFoundBit | (initialized_ ? kInitializedBit : 0) | (locked_ ? kReflectorFoundBit : 0);
  }
  Direction direction() const { return direction_to(aim_mm_); }
  Direction direction_to(const Eigen::Vector3d& p_mm) const {
    const Eigen::Vector3d hvd = in_system(CoordinateSystem::Scc, p_mm);
    return {settings_.from_rad(hvd[0]), settings_.from_rad(hvd[1])};
  }
  Eigen::Vector3d turned(const Direction& by) const {
    Eigen::Vector3d hvd = in_system(CoordinateSystem::Scc, aim_mm_);
    hvd[0] += settings_.to_rad(by.horizontal);
    hvd[1] += settings_.to_rad(by.vertical);
    return out_of_system(CoordinateSystem::Scc, hvd);
  }

  // ---- Jobs: commands that take time, one at once. A job whose number is no longer the current one was
  // dropped. ----

  using Job = std::uint64_t;

  Job begin_job() {
    job_ = ++last_job_;
    return *job_;
  }
  void drop_job() {
    job_.reset();
    measuring_ = false;
    job_timer_.cancel();
  }
  void end_job(CommandCode code, std::int32_t status) {
    drop_job();
    answer(code, status);
  }
  void spawn(asio::awaitable<void> job) {
    asio::co_spawn(acceptor_.get_executor(), std::move(job), asio::detached);
  }

  /// @return whether the job goes on
  asio::awaitable<bool> wait(Job job, Clock::duration simulated) {
    job_timer_.expires_after(scaled(simulated));
    co_await job_timer_.async_wait(kToResult);
    co_return !closed_ && job_ == job;
  }
  Clock::duration scaled(Clock::duration simulated) const {
    return std::chrono::duration_cast<Clock::duration>(simulated / options_.speedup);
  }

  static asio::awaitable<void> initialize(Self self, Job job) {
    self->lose_lock();
    const bool going_on = co_await self->wait(job, kInitializeTime);
    if (!going_on) co_return;
    self->initialized_ = true;
    self->face_ = 1;
    self->end_job(CommandCode::Initialize, status::kAllOk);
    self->report(SystemEvent::InitializationChanged);
  }

  static asio::awaitable<void> drive(Self self, Job job, CommandCode code, Eigen::Vector3d aim_mm) {
    self->lose_lock();
    const bool going_on = co_await self->wait(job, kDriveTime);
    if (!going_on) co_return;
    self->aim_mm_ = aim_mm;
    self->end_job(code, status::kAllOk);
  }

  /// Comes to point where it did, with no reflector locked.
  static asio::awaitable<void> turn_over(Self self, Job job) {
    self->lose_lock();
    const bool going_on = co_await self->wait(job, kDriveTime);
    if (!going_on) co_return;
    self->face_ = 3 - self->face_;
    self->end_job(CommandCode::ChangeFace, status::kAllOk);
  }

  /// Drives, locks within the search radius, measures. Its answer says that the measurement has begun.
  static asio::awaitable<void> go_and_measure(Self self, Job job, Eigen::Vector3d aim_mm) {
    self->lose_lock();
    const bool going_on = co_await self->wait(job, kDriveTime);
    if (!going_on) co_return;
    self->aim_mm_ = aim_mm;
    self->lock();
    if (!self->locked_) co_return self->end_job(CommandCode::GoAndMeasure, kSimulatedNoTarget);
    self->answer(CommandCode::GoAndMeasure, status::kAllOk);
    co_await measure(self, job);
  }

  static asio::awaitable<void> search(Self self, Job job) {
    const auto timeout = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double, std::milli>{self->settings_.search_timeout_ms()});
    bool going_on = co_await self->wait(job, std::min<Clock::duration>(kSearchTime, timeout));
    if (!going_on) co_return;
    self->lock();
    if (!self->locked_) {
      going_on = co_await self->wait(job, timeout);
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
    const auto between = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double, std::milli>{self->settings_.measure_ms() / kReadings});
    std::vector<Eigen::Vector3d> readings_mm;
    for (int i = 0; i < kReadings; ++i) {
      const bool going_on = co_await self->wait(job, between);
      if (!going_on) co_return;
      self->update_lock();
      if (self->job_ != job) co_return;  // the beam broke and ended this measurement
      // Scaled so that the mean of the readings scatters as the noise of one point says.
      const Eigen::Vector3d noise_mm = self->noise_(self->aim_mm_) - self->aim_mm_;
      readings_mm.push_back(self->read(self->aim_mm_) + self->disturbance_.bias_mm +
                            std::sqrt(double{kReadings}) * noise_mm);
    }
    self->drop_job();
    ++self->measurements_;
    self->send_result(readings_mm);
    self->report(SystemEvent::MeasurementReady);
  }

  void send_result(const std::vector<Eigen::Vector3d>& readings_mm) {
    Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& reading_mm : readings_mm) mean_mm += reading_mm / kReadings;
    Eigen::Vector3d variance = Eigen::Vector3d::Zero();  // of the mean
    for (const Eigen::Vector3d& reading_mm : readings_mm) {
      variance += (reading_mm - mean_mm).cwiseAbs2() / (kReadings * (kReadings - 1.0));
    }
    const Eigen::Vector3d std_mm = variance.cwiseSqrt();
    last_measured_mm_ = mean_mm;
    const auto fill = [&](auto result) {
      result.v = settings_.point(mean_mm);
      result.std = settings_.deviations(mean_mm, std_mm);
      result.std_total = settings_.from_mm(std_mm.norm());
      if (disturbance_.std_mm) {
        result.std_total = settings_.from_mm(*disturbance_.std_mm);
        result.std.fill(result.std_total);
      }
      result.environment = by_station() ? settings_.from_metric(station_air()) : settings_.environment();
      send(result);
    };
    if (settings_.extended_statistics()) return fill(SingleMeasResult2{});
    fill(SingleMeasResult{});
  }

  // ---- The instrument ----

  /// That its weather station reports.
  Air station_air() const {
    return {disturbance_.temperature_c, disturbance_.pressure_mbar, disturbance_.humidity_percent};
  }
  bool by_station() const { return options_.instrument.weather_station && settings_.computes_refraction(); }

  /// What it makes of a point that stands there, but for its noise.
  Eigen::Vector3d read(const Eigen::Vector3d& p_mm) const {
    const TrackerInstrument& instrument = options_.instrument;
    const Eigen::Vector3d aimed_mm = instrument.aiming.seen(p_mm, face_);
    if (!instrument.air) return aimed_mm;
    const double taken = by_station() ? edlen_group_index(station_air()) : settings_.adm_index();
    return edlen_group_index(*instrument.air) / taken * aimed_mm;
  }

  // ---- The beam ----

  /// The arm's reflector is 0, those beside it follow.
  using Reflector = std::size_t;

  /// Where the beam finds a reflector now; nothing while it is hidden or the beam is broken.
  std::optional<Eigen::Vector3d> seen(Reflector reflector) const {
    if (Clock::now() < blocked_until_) return std::nullopt;
    const auto& nests_mm = options_.instrument.nests_mm;
    std::optional<Eigen::Vector3d> p_mm =
        reflector == 0 ? target_.look().p_WS_mm : std::optional{nests_mm[reflector - 1]};
    if (p_mm) *p_mm += disturbance_.moved_mm;
    return p_mm;
  }

  std::optional<Reflector> nearest_to(const Eigen::Vector3d& p_mm, double radius_mm) const {
    std::optional<Reflector> nearest;
    for (Reflector reflector = 0; reflector <= options_.instrument.nests_mm.size(); ++reflector) {
      const auto at_mm = seen(reflector);
      if (!at_mm || (*at_mm - p_mm).norm() > radius_mm) continue;
      radius_mm = (*at_mm - p_mm).norm();
      nearest = reflector;
    }
    return nearest;
  }

  /// Locks to the reflector that is seen within the search radius of where the beam points.
  void lock() { lock_within(settings_.search_radius_mm()); }

  void lock_within(double radius_mm) {
    const auto found = nearest_to(aim_mm_, radius_mm);
    locked_ = found.has_value();
    if (!found) return;
    locked_to_ = *found;
    update_lock();
  }

  /// PowerLock finds a reflector by itself, wherever the beam points.
  void lock_by_itself() {
    if (locked_ || job_ || !initialized_ || !(options_.power_lock || settings_.power_lock())) return;
    lock_within(std::numeric_limits<double>::infinity());
    if (locked_) report(SystemEvent::MeasurementReady);
  }

  void update_lock() {
    if (!locked_) return;
    if (const auto p_mm = seen(locked_to_)) {
      aim_mm_ = *p_mm;
    } else {
      lose_lock();
    }
  }

  void lose_lock() {
    if (!locked_) return;
    locked_ = false;
    report(SystemEvent::MeasurementNotReady);
    if (!measuring_) return;
    drop_job();
    send(ErrorReport{CommandCode::StartMeasurement, kSimulatedBeamBroken});
  }

  void storm() {
    constexpr int kAtOnce = 5;
    for (int i = 0; i < kAtOnce; ++i) report(SystemEvent::EnvironmentChanged);
  }

  static asio::awaitable<void> watch(Self self) {
    const auto period = std::clamp<Clock::duration>(self->scaled(20ms), 1ms, 20ms);
    Clock::time_point last_position;
    for (;;) {
      self->watch_timer_.expires_after(period);
      co_await self->watch_timer_.async_wait(kToResult);
      if (self->closed_) co_return;
      self->update_lock();
      self->lock_by_itself();
      if (self->disturbance_.storms) self->storm();
      const bool due = Clock::now() - last_position >= kReflectorPositionPeriod;
      if (!self->locked_ || !due || !self->settings_.sends_reflector_position()) continue;
      last_position = Clock::now();
      self->send(ReflectorPosResult{status::kAllOk, self->settings_.point(self->aim_mm_)});
    }
  }

  const SimulatedTarget& target_;
  const TrackerNoise noise_;
  const EmsconServerOptions options_;
  tcp::acceptor acceptor_;
  asio::steady_timer job_timer_, watch_timer_;
  std::shared_ptr<Client> client_;
  bool closed_ = false;

  TrackerDisturbance disturbance_;
  TrackerSettings settings_;
  bool initialized_ = false;
  bool locked_ = false;
  Reflector locked_to_ = 0;
  Eigen::Vector3d aim_mm_{1000, 0, 0};  ///< where the beam points; the reflector's true centre while locked
  Clock::time_point blocked_until_;
  std::optional<Job> job_;
  Job last_job_ = 0;
  bool measuring_ = false;  ///< the job is a measurement
  std::optional<Eigen::Vector3d> last_measured_mm_;
  std::int32_t face_ = 1;
  std::uint64_t measurements_ = 0;
};

EmsconServer::EmsconServer(asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
                           EmsconServerOptions options)
    : state_{std::make_shared<State>(std::move(executor), target, std::move(noise), std::move(options))} {
  state_->start();
}

EmsconServer::~EmsconServer() { state_->close(); }

std::uint16_t EmsconServer::port() const { return state_->port(); }
std::uint64_t EmsconServer::measurements() const { return state_->measurements(); }
void EmsconServer::disturb(const TrackerDisturbance& disturbance) { state_->disturb(disturbance); }
void EmsconServer::beam_break(std::chrono::milliseconds duration) { state_->beam_break(duration); }
void EmsconServer::restart() { state_->restart(); }

}  // namespace truepose::sim
