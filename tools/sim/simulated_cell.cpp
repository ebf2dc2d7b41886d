#include "tools/sim/simulated_cell.hpp"

#include <boost/asio/post.hpp>
#include <boost/system/system_error.hpp>
#include <cstdio>
#include <utility>

#include "core/kinematics/angles.hpp"
#include "core/simulation/tracker_noise.hpp"
#include "tools/sim/port_error.hpp"

namespace truepose::sim {

using std::chrono::steady_clock;

namespace {

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

TrackerNoise tracker_noise(const config::Scenario& scenario, Random& random) {
  const TrackerNoiseModel model{.range_mm = scenario.noise.range_mm,
                                .range_mm_per_m = scenario.noise.range_mm_per_m,
                                .transverse_mm = scenario.noise.transverse_mm,
                                .transverse_mm_per_m = scenario.noise.transverse_mm_per_m};
  return
      [model, &random](const Eigen::Vector3d& p_true_mm) { return noisy_reading(p_true_mm, model, random); };
}

EmsconServer listening_tracker(const boost::asio::any_io_executor& executor, const SimulatedTarget& target,
                               TrackerNoise noise, const CellOptions& cell) {
  EmsconServerOptions options;
  options.address = cell.address;
  options.port = cell.tracker_port;
  options.speedup = cell.speedup;
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
      tracker_{listening_tracker(executor, *this, tracker_noise(scenario_, noise_random_), options_)} {
  schedule_faults();
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
  const RsiSetup setup{.nominal = scenario_.nominal,
                       .ethernet = ethernet_,
                       .cycle = scenario_.cycle,
                       .timeout_cycles = scenario_.rsi_timeout_cycles,
                       .axis_corr_limit_rad = scenario_.axis_corr_limit_deg * kRadPerDeg};
  const std::vector<JointVector> points =
      scenario_.stream_path.empty() ? std::vector{home(scenario_)} : scenario_.stream_path;
  // A counter of the controller's milliseconds, so a new session is seen to be one.
  const auto ipoc =
      std::chrono::floor<std::chrono::milliseconds>(steady_clock::now().time_since_epoch()).count();
  RsiClient client{setup, StreamPath{scenario_.nominal, points, speed_scale},
                   static_cast<std::uint64_t>(ipoc)};
  const RsiRunnerOptions options{
      .host = options_.rsi_host, .port = options_.rsi_port, .cycle = scenario_.cycle};
  rsi_ = std::make_unique<RsiRunner>(options, std::move(client),
                                     [this, session = ended_sessions_.sessions](RsiEnd end) {
                                       boost::asio::post(executor_, [=, this] { rsi_ended(session, end); });
                                     });
}

void SimulatedCell::end_rsi() {
  const std::unique_ptr<RsiRunner> ended = std::exchange(rsi_, nullptr);
  ended->stop();
  ended_sessions_.add(ended->statistics());
}

void SimulatedCell::rsi_ended(std::uint64_t session, RsiEnd end) {
  if (!rsi_ || session != ended_sessions_.sessions) return;  // a stop came first
  if (end == RsiEnd::Timeout) {
    std::fprintf(stderr,
                 "KSS29002: Object ETHERNET1 returns error RSITimeout: %d cycles without a valid reply\n",
                 scenario_.rsi_timeout_cycles);
  }
  observe_rsi();
  follow(controller_.rsi_ended(end, now()));
}

void SimulatedCell::schedule_faults() {
  for (const config::Scenario::Fault& fault : scenario_.faults) {
    faults_.emplace_back(executor_, start_ + shortened(fault.at, options_.speedup));
    faults_.back().async_wait([this, fault](boost::system::error_code cancelled) {
      if (!cancelled) misbehave(fault);
    });
  }
}

void SimulatedCell::misbehave(const config::Scenario::Fault& fault) {
  const auto shorter = std::chrono::ceil<std::chrono::milliseconds>(shortened(fault.lasts, options_.speedup));
  if (fault.kind == "beam-break") tracker_.beam_break(shorter);
  if (fault.kind == "tracker-restart") tracker_.restart();
  if (fault.kind == "eki-drop") eki_.drop(shorter);
  if (fault.kind == "rsi-drop" && rsi_) rsi_->drop(fault.lasts);  // RSI keeps real time
}

}  // namespace truepose::sim
