#include "tools/sim/simulated_cell.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/system/system_error.hpp>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "core/math/angles.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose::sim {

using std::chrono::steady_clock;

namespace {

using Kind = config::ScenarioFault::Kind;

/// Streams of random numbers that must not share a seed.
constexpr std::uint64_t kNoiseStream = 0x6e6f697365u;

/// Where the arm stands at first, and where the RSI program starts.
JointVector home(const config::Scenario& scenario) {
  if (!scenario.stream_path.empty()) return scenario.stream_path.front();
  JointVector q(scenario.nominal.joint_count());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = scenario.nominal.joints[static_cast<std::size_t>(i)];
    q[i] = (joint.min + joint.max) / 2;
  }
  return q;
}

ControllerSetup controller_setup(const config::Scenario& scenario) {
  return {.nominal = scenario.nominal,
          .model = scenario.robot_model,
          .serial = scenario.robot_serial,
          .start = home(scenario),
          .rsi_start = home(scenario)};
}

TrueArmSetup arm_setup(const config::Scenario& scenario) {
  return {.robot = scenario.truth,
          .non_geometric = scenario.drives,
          .X_WB = scenario.X_WB,
          .p_FS_mm = scenario.p_FS_mm,
          .facing_F = scenario.facing_F,
          .acceptance_rad = scenario.acceptance_deg * kRadPerDeg,
          .repeatability_mm = scenario.repeatability_mm};
}

TrackerNoiseModel noise_model(const config::Scenario& scenario) {
  return {.range_mm = scenario.noise.range_mm,
          .range_mm_per_m = scenario.noise.range_mm_per_m,
          .transverse_mm = scenario.noise.transverse_mm,
          .transverse_mm_per_m = scenario.noise.transverse_mm_per_m};
}

ServoSetup servo_setup(const config::Scenario& scenario) {
  using Ms = std::chrono::duration<double, std::milli>;
  ServoSetup servo{.dead_time = Ms{scenario.dead_time_ms}, .lag = {}};
  const bool of_each = scenario.lag_ms.size() > 1;
  for (std::size_t i = 0; i < scenario.nominal.joints.size(); ++i)
    servo.lag.push_back(Ms{scenario.lag_ms[of_each ? i : 0]});
  return servo;
}

bool is_of_rsi(const config::ScenarioFault& fault) {
  return fault.kind >= config::ScenarioFault::Kind::RsiDrop;
}

EmsconServer listening_tracker(const boost::asio::any_io_executor& executor, const SimulatedTarget& target,
                               TrackerNoise noise, std::function<void(std::uint64_t)> before_point,
                               const config::Scenario& scenario, const CellOptions& cell) {
  EmsconServerOptions options;
  options.address = cell.address;
  options.port = cell.tracker_port;
  options.speedup = cell.speedup;
  options.power_lock = scenario.power_lock;
  options.before_point = std::move(before_point);
  try {
    return {executor, target, std::move(noise), options};
  } catch (const boost::system::system_error& e) {
    throw PortError{"tracker", cell.tracker_port, e.code()};
  }
}

steady_clock::duration shortened(std::chrono::nanoseconds time, double speedup) {
  return std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double, std::nano>(time) /
                                                            speedup);
}

}  // namespace

SimulatedCell::SimulatedCell(boost::asio::any_io_executor executor, config::Scenario scenario,
                             rsi::EthernetConfig ethernet, CellOptions options)
    : executor_{executor},
      scenario_{std::move(scenario)},
      ethernet_{std::move(ethernet)},
      options_{std::move(options)},
      arm_{arm_setup(scenario_), options_.seed},
      noise_random_{options_.seed ^ kNoiseStream},
      controller_{controller_setup(scenario_)},
      next_change_{executor},
      eki_{executor,
           {.address = options_.address,
            .motion_port = options_.eki_port,
            .state_port = static_cast<std::uint16_t>(options_.eki_port == 0 ? 0 : options_.eki_port + 1)},
           *this},
      tracker_{listening_tracker(
          executor, *this, [this](const Eigen::Vector3d& p_true_mm) { return measured(p_true_mm); },
          [this](std::uint64_t number) { point_begins(number); }, scenario_, options_)} {
  if (const auto reason = unsendable(ethernet_)) throw std::invalid_argument{*reason};
  for (const config::ScenarioFault& fault : scenario_.faults) {
    if (fault.unit == config::ScenarioFault::Unit::Milliseconds)
      schedule(fault, std::chrono::milliseconds{fault.at});
  }
  disturb_tracker();
}

SimulatedCell::~SimulatedCell() = default;

SimulatedCell::Ports SimulatedCell::ports() const {
  return {eki_.motion_port(), eki_.state_port(), tracker_.port()};
}

CellStatistics SimulatedCell::statistics() const {
  CellStatistics statistics{
      .rsi = ended_sessions_, .moves = controller_.moves(), .measurements = tracker_.measurements()};
  if (rsi_) statistics.rsi.add(rsi_->statistics());
  return statistics;
}

void SimulatedCell::motion_connected() { eki_.send_motion(controller_.hello()); }

void SimulatedCell::motion_lost() {
  observe_rsi();
  controller_.link_lost(now());
  follow({});
}

void SimulatedCell::command(const eki::Command& command) {
  observe_rsi();
  follow(controller_.command(command, now()));
}

void SimulatedCell::control(const eki::Control& control) {
  observe_rsi();
  KukaController::ControlAnswer answer = controller_.control(control, now());
  eki_.send_state(answer.state);
  follow(std::move(answer.acks));
}

TargetSight SimulatedCell::look() const {
  TargetSight sight{.p_WS_mm = std::nullopt, .moving = false, .stamp = steady_clock::now()};
  const RsiRunner::Arm arm =
      rsi_ ? rsi_->arm() : RsiRunner::Arm{controller_.axes(now()), controller_.moving(now())};
  sight.moving = arm.moving;
  if (arm_.visible(arm.q)) sight.p_WS_mm = arm_.p_WS_mm(arm.q);
  return sight;
}

SimTime SimulatedCell::now() const {
  const std::chrono::duration<double, std::nano> real = steady_clock::now() - start_;
  return std::chrono::duration_cast<SimTime>(real * options_.speedup);
}

/// While RSI is open its cycles drive the arm, on a thread of their own.
void SimulatedCell::observe_rsi() {
  if (!rsi_) return;
  const RsiRunner::Arm arm = rsi_->arm();
  controller_.rsi_cycle(arm.q, arm.moving);
}

/// Says what the controller has said, and makes the rest of the cell agree with the controller's new state.
void SimulatedCell::follow(std::vector<eki::Ack> said) {
  for (const eki::Ack& ack : controller_.advance(now())) said.push_back(ack);
  for (const eki::Ack& ack : said) eki_.send_motion(ack);

  for (; stops_seen_ < controller_.stops(); ++stops_seen_) arm_.move_to(controller_.axes(now()));

  const std::optional<double> rsi_speed = controller_.rsi_speed();
  if (rsi_speed && !rsi_) start_rsi(*rsi_speed);
  if (!rsi_speed && rsi_) end_rsi();

  const std::optional<SimTime> change = controller_.next_change();
  if (!change) {
    next_change_.cancel();
    return;
  }
  next_change_.expires_at(start_ + shortened(*change, options_.speedup));
  next_change_.async_wait([this](boost::system::error_code cancelled) {
    if (!cancelled) follow({});
  });
}

void SimulatedCell::start_rsi(double speed_scale) {
  ++sessions_begun_;
  const RsiSetup setup{.nominal = scenario_.rsi_arm.value_or(scenario_.nominal),
                       .ethernet = ethernet_,
                       .cycle = scenario_.cycle,
                       .timeout_cycles = scenario_.rsi_timeout_cycles,
                       .axis_corr_limit_rad = scenario_.axis_corr_limit_deg * kRadPerDeg,
                       .servo = servo_setup(scenario_),
                       .hold_on = scenario_.hold_on,
                       .ignores_correction = scenario_.ignores_correction,
                       .consecutive_delay = scenario_.consecutive_delay,
                       .decimals = scenario_.rsi_decimals};
  const std::vector<JointVector> points =
      scenario_.stream_path.empty() ? std::vector{home(scenario_)} : scenario_.stream_path;
  // A counter of the controller's milliseconds, so a new session is seen to be one.
  const auto ipoc =
      std::chrono::floor<std::chrono::milliseconds>(steady_clock::now().time_since_epoch()).count();
  RsiClient client{setup, StreamPath{scenario_.nominal, points, speed_scale},
                   static_cast<std::uint64_t>(ipoc)};
  const RsiRunnerOptions options{.host = options_.rsi_host,
                                 .port = options_.rsi_port,
                                 .cycle = scenario_.cycle,
                                 .source_port = scenario_.rsi_source_port,
                                 .faults = rsi_faults(),
                                 .cycles_before = ended_sessions_.counters.cycles};
  const auto ended = [this, session = sessions_begun_](RsiEnd end) {
    boost::asio::post(executor_, [=, this] { rsi_ended(session, end); });
  };
  const auto stranger = [this](const std::string& name) {
    boost::asio::post(executor_, [=, this] { tell_of_stranger(name); });
  };
  rsi_ = std::make_unique<RsiRunner>(options, std::move(client), RsiListener{ended, stranger});
}

void SimulatedCell::end_rsi() {
  const std::unique_ptr<RsiRunner> ended = std::exchange(rsi_, nullptr);
  ended->stop();
  ended_sessions_.add(ended->statistics());
}

void SimulatedCell::rsi_ended(std::uint64_t session, RsiEnd end) {
  if (!rsi_ || session != sessions_begun_) return;  // a stop came first
  if (end == RsiEnd::Timeout) {
    std::fprintf(stderr,
                 "KSS29002: Object ETHERNET1 returns error RSITimeout: %d cycles without a valid reply\n",
                 scenario_.rsi_timeout_cycles);
  }
  observe_rsi();
  follow(controller_.rsi_ended(end, now()));
}

void SimulatedCell::tell_of_stranger(const std::string& name) {
  if (!strangers_told_.insert(name).second) return;
  std::fprintf(stderr,
               "RSI: the replies have %s, which the RECEIVE list of the ethernet configuration does not: a "
               "controller ignores it without a word\n",
               name.c_str());
}

// ---- Faults ----

/// @param at  of scaled time, since the start
void SimulatedCell::schedule(const config::ScenarioFault& fault, std::chrono::milliseconds at) {
  const auto timer =
      fault_timers_.emplace(fault_timers_.end(), executor_, start_ + shortened(at, options_.speedup));
  timer->async_wait([this, timer, fault, at](boost::system::error_code cancelled) {
    if (cancelled) return;
    misbehave(fault);
    if (fault.every > 0) schedule(fault, at + std::chrono::milliseconds{fault.every});
    fault_timers_.erase(timer);
  });
}

void SimulatedCell::misbehave(const config::ScenarioFault& fault) {
  const std::chrono::milliseconds lasts{fault.lasts};
  const auto shorter = std::chrono::ceil<std::chrono::milliseconds>(shortened(lasts, options_.speedup));
  if (is_of_rsi(fault)) {
    if (rsi_) rsi_->disturb(in_cycles(fault));
  } else if (fault.kind == Kind::BeamBreak) {
    tracker_.beam_break(shorter);
  } else if (fault.kind == Kind::TrackerRestart) {
    tracker_.restart();
  } else if (fault.kind == Kind::EkiDrop) {
    eki_.drop(shorter);
  } else {
    disturb_tracker();
    if (fault.lasts == 0) return;
    const auto timer =
        fault_timers_.emplace(fault_timers_.end(), executor_, std::chrono::steady_clock::now() + shorter);
    timer->async_wait([this, timer](boost::system::error_code cancelled) {
      if (cancelled) return;
      disturb_tracker();
      fault_timers_.erase(timer);
    });
  }
}

/// RSI keeps real time, so its ms are not scaled.
config::ScenarioFault SimulatedCell::in_cycles(config::ScenarioFault fault) const {
  const std::int64_t cycle_ms = scenario_.cycle.count();
  fault.unit = config::ScenarioFault::Unit::Cycles;
  fault.lasts = (fault.lasts + cycle_ms - 1) / cycle_ms;
  fault.every = 0;  // comes again by its timer
  return fault;
}

std::vector<config::ScenarioFault> SimulatedCell::rsi_faults() const {
  std::vector<config::ScenarioFault> faults;
  std::ranges::copy_if(scenario_.faults, std::back_inserter(faults), [](const config::ScenarioFault& fault) {
    return is_of_rsi(fault) && fault.unit == config::ScenarioFault::Unit::Cycles;
  });
  return faults;
}

void SimulatedCell::point_begins(std::uint64_t number) {
  point_ = number;
  disturb_tracker();
}

/// What the scenario says of the tracker at this time and this point, all together.
void SimulatedCell::disturb_tracker() {
  // A timer rings a rounding error before its time.
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(now()).count();
  TrackerDisturbance disturbance{.bias_mm = scenario_.bias_mm,
                                 .std_mm = scenario_.std_mm,
                                 .temperature_c = scenario_.air.temperature_c,
                                 .pressure_mbar = scenario_.air.pressure_mbar,
                                 .humidity_percent = scenario_.air.humidity_percent};
  double extra_variance = 0;
  for (const config::ScenarioFault& fault : scenario_.faults) {
    const bool by_point = fault.unit == config::ScenarioFault::Unit::Points;
    if (!fault.covers(by_point ? static_cast<std::int64_t>(point_) : ms)) continue;
    if (fault.kind == Kind::TrackerBump) disturbance.moved_mm += fault.by_mm;
    if (fault.kind == Kind::TrackerBias) disturbance.bias_mm += fault.by_mm;
    if (fault.kind == Kind::TrackerNoise) extra_variance += fault.sigma_mm * fault.sigma_mm;
    if (fault.kind == Kind::TrackerStd) disturbance.std_mm = fault.std_mm;
    if (fault.kind != Kind::TrackerAir) continue;
    disturbance.temperature_c = fault.temperature_c;
    disturbance.pressure_mbar = fault.pressure_mbar;
    disturbance.humidity_percent = fault.humidity_percent;
  }
  extra_sigma_mm_ = std::sqrt(extra_variance);
  tracker_.disturb(disturbance);
}

Eigen::Vector3d SimulatedCell::measured(const Eigen::Vector3d& p_true_mm) {
  Eigen::Vector3d p_mm = noisy_reading(p_true_mm, noise_model(scenario_), noise_random_);
  if (extra_sigma_mm_ > 0) {
    for (double& coordinate : p_mm) coordinate += extra_sigma_mm_ * noise_random_.normal();
  }
  return p_mm;
}

}  // namespace truepose::sim
