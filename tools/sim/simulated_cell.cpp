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
#include "tools/sim/tracker/bridge_server.hpp"
#include "tools/sim/tracker/emscon_server.hpp"

namespace truepose::sim {

namespace {

/// Streams of random numbers that must not share a seed.
constexpr std::uint64_t kNoiseStream = 0x6e6f697365u, kOrientationStream = 0x7475726eu;

/// The controller's channels that truepose uses.
const std::string kCellLink = "CellLink", kCellState = "CellState";

constexpr double kBeamRadius_mm = 5;

/// No more often is the controller looked at while RSI is off.
constexpr std::chrono::milliseconds kShortest{1};

TrueArmSetup arm_setup(const config::Scenario& scenario) {
  return {.robot = scenario.truth,
          .non_geometric = scenario.drives,
          .warm_up = scenario.warm_up,
          .X_WB = scenario.X_WB,
          .p_FS_mm = scenario.p_FS_mm,
          .facing_F = scenario.facing_F,
          .acceptance_rad = scenario.acceptance_deg * kRadPerDeg,
          .repeatability_mm = scenario.repeatability_mm,
          .further = scenario.further_reflectors,
          .R_FT = scenario.target_6d.value_or(config::SixDTarget{}).R_FT};
}

/// What the tracker could see of the arm's reflectors for the arm's body.
std::optional<PoseChecker> sight_of(const config::Scenario& scenario) {
  if (scenario.body.empty()) return std::nullopt;
  Scene scene{.robot = scenario.truth, .body = scenario.body};
  scene.sight = {.X_WB = scenario.X_WB,
                 .p_FS_mm = scenario.p_FS_mm,
                 .facing_F = scenario.facing_F,
                 .acceptance_rad = scenario.acceptance_deg * kRadPerDeg,
                 .beam_radius_mm = kBeamRadius_mm};
  for (const TrueReflector& reflector : scenario.further_reflectors)
    scene.sight.further.push_back({reflector.p_FS_mm, reflector.facing_F, reflector.acceptance_rad});
  return PoseChecker{std::move(scene)};
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

std::unique_ptr<TrackerServer> listening_tracker(const Machine& machine, const SimulatedTarget& target,
                                                 TrackerNoise noise, OrientationNoise orientation_noise,
                                                 std::function<void(std::uint64_t)> before_point,
                                                 const config::Scenario& scenario, const CellOptions& cell) {
  TrackerServerOptions options;
  options.address = cell.address;
  options.port = cell.bridge_port.value_or(cell.tracker_port);
  options.speedup = cell.speedup;
  options.power_lock = scenario.power_lock;
  options.instrument = scenario.instrument;
  options.orientation_noise = std::move(orientation_noise);
  options.before_point = std::move(before_point);
  try {
    if (cell.bridge_port)
      return std::make_unique<BridgeServer>(machine, target, std::move(noise), std::move(options));
    return std::make_unique<EmsconServer>(machine, target, std::move(noise), std::move(options));
  } catch (const boost::system::system_error& e) {
    throw PortError{"tracker", cell.bridge_port.value_or(cell.tracker_port), e.code()};
  }
}

/// Empty where the scenario has no 6-D target.
OrientationNoise orientation_noise(const config::Scenario& scenario, std::uint64_t seed) {
  if (!scenario.target_6d) return {};
  const double sigma_rad = scenario.target_6d->sigma_rad;
  return [sigma_rad, random = Random{seed ^ kOrientationStream}](const Eigen::Matrix3d& R_true) mutable {
    return noisy_orientation(R_true, sigma_rad, random);
  };
}

/// @param contexts  filled with those of the controller; outlive it
ControllerSetup listening_controller(const config::Scenario& scenario, RsiContexts& contexts,
                                     std::function<void()> on_news, PathLog* path) {
  ControllerSetup setup = controller_setup(scenario);
  contexts = rsi_contexts(scenario, setup.programs);
  setup.contexts.clear();
  for (const auto& [name, context] : contexts) setup.contexts.push_back(name);
  setup.rsi_parameter = [&contexts](const std::string& context, const RsiParameter& parameter) {
    return value_of(contexts.at(context), parameter);
  };
  for (const std::string& channel : {kCellLink, kCellState}) {
    const auto names_it = [&](const krl::Source& program) {
      return program.text.find('"' + channel + '"') != std::string::npos;
    };
    if (!setup.eki_files.contains(channel) && std::ranges::any_of(setup.programs, names_it))
      throw std::invalid_argument{"the controller has no " + channel +
                                  ".xml in its eki folder, and its programs name that channel"};
  }
  setup.on_news = std::move(on_news);
  if (path != nullptr) setup.on_cycle = [path](const ProgramCycle& cycle) { path->take(cycle); };
  return setup;
}

/// truepose's own channels where the command line wants them, the others where their files do.
std::vector<EkiPort> eki_ports(const Controller& controller, std::uint16_t first) {
  std::vector<EkiPort> ports;
  for (const auto& [channel, port] : controller.eki_ports()) {
    if (channel == kCellLink) {
      ports.push_back({channel, first});
    } else if (channel == kCellState) {
      ports.push_back({channel, static_cast<std::uint16_t>(first == 0 ? 0 : first + 1)});
    } else {
      ports.push_back({.channel = channel, .port = port, .is_taken_late = true});
    }
  }
  return ports;
}

std::unique_ptr<PathLog> path_log(const config::Scenario& scenario, const std::filesystem::path& file) {
  if (file.empty()) return nullptr;
  return std::make_unique<PathLog>(file, scenario.nominal, arm_setup(scenario));
}

}  // namespace

SimulatedCell::SimulatedCell(Machine machine, config::Scenario scenario, rsi::EthernetConfig ethernet,
                             CellOptions options)
    : machine_{std::move(machine)},
      scenario_{std::move(scenario)},
      ethernet_{std::move(ethernet)},
      options_{std::move(options)},
      arm_{arm_setup(scenario_), options_.seed},
      sight_{sight_of(scenario_)},
      noise_random_{options_.seed ^ kNoiseStream},
      path_{path_log(scenario_, options_.path_file)},
      controller_{listening_controller(
          scenario_, contexts_, [this] { boost::asio::post(machine_.io, [this] { follow(); }); },
          path_.get())},
      next_change_{machine_.io, machine_.clock},
      alarms_{machine_.io, machine_.clock},
      eki_ports_{eki_ports(controller_, options_.eki_port)},
      eki_{machine_, options_.address, eki_ports_, *this},
      tracker_{listening_tracker(
          machine_, *this, [this](const Eigen::Vector3d& p_true_mm) { return measured(p_true_mm); },
          orientation_noise(scenario_, options_.seed), [this](std::uint64_t number) { point_begins(number); },
          scenario_, options_)} {
  if (const auto reason = unsendable(ethernet_)) throw std::invalid_argument{*reason};
  for (const config::ScenarioFault& fault : scenario_.faults) {
    if (fault.unit == config::ScenarioFault::Unit::Milliseconds)
      schedule(fault, std::chrono::milliseconds{fault.at});
  }
  disturb_tracker();
  constexpr std::chrono::seconds kBoot{1};  // its programs have opened their channels
  controller_.advance(kBoot);
  follow();
}

SimulatedCell::~SimulatedCell() {
  rsi_.reset();
  flush_path();
}

void SimulatedCell::flush_path() {
  if (path_) path_->flush();
}

SimulatedCell::Ports SimulatedCell::ports() const {
  Ports ports{eki_.port(kCellLink), eki_.port(kCellState), tracker_->port(), {}};
  for (EkiPort its : eki_ports_) {
    if (!its.is_taken_late) continue;
    if (const std::uint16_t taken = eki_.port(its.channel); taken != 0) its.port = taken;
    ports.others.push_back(std::move(its));
  }
  return ports;
}

CellStatistics SimulatedCell::statistics() const {
  CellStatistics statistics{
      .rsi = ended_sessions_, .moves = controller_.moves(), .measurements = tracker_->measurements()};
  if (!rsi_) return statistics;
  statistics.rsi.add(rsi_->statistics());
  statistics.rsi.correction_in_effect_rad = statistics.rsi.counters.correction_rad;
  return statistics;
}

bool SimulatedCell::connected(const std::string& channel) {
  pass_time();
  const bool taken = controller_.connect(channel);
  follow();
  return taken;
}

void SimulatedCell::lost(const std::string& channel) {
  pass_time();
  controller_.disconnect(channel);
  follow();
}

void SimulatedCell::received(const std::string& channel, std::string_view document) {
  pass_time();
  controller_.receive(channel, document);
  follow();
}

JointVector SimulatedCell::axes() const { return rsi_ ? rsi_->axes() : controller_.axes(); }

TargetSight SimulatedCell::look() const {
  const JointVector q = axes();
  // The tracker looks often, and the arm stands for long.
  if (!seen_ || seen_at_ != q) {
    seen_ = seen_of(q);
    seen_at_ = q;
  }
  return *seen_;
}

/// What the tracker sees of the arm while that stands so.
TargetSight SimulatedCell::seen_of(const JointVector& q) const {
  TargetSight sight;
  std::vector<int> unhidden;
  if (sight_) unhidden = sight_->seen_at(q);
  for (std::size_t k = 0; k < arm_.reflectors(); ++k) {
    const bool hidden = sight_ && std::ranges::find(unhidden, static_cast<int>(k)) == unhidden.end();
    std::optional<Eigen::Vector3d> p_mm;
    if (!hidden && arm_.visible(q, k)) p_mm = arm_.p_WS_mm(q, k);
    if (k == 0) {
      sight.p_WS_mm = p_mm;
      sight.R_WT = arm_.R_WT(q);
    } else {
      sight.others_mm.push_back(p_mm);
    }
  }
  return sight;
}

SimTime SimulatedCell::now() const {
  const std::chrono::duration<double, std::nano> real = machine_.clock.now() - start_;
  return std::chrono::duration_cast<SimTime>(real * options_.speedup);
}

/// As long as the cell takes for it.
drivers::Duration SimulatedCell::shortened(std::chrono::nanoseconds time) const {
  return std::chrono::duration_cast<drivers::Duration>(std::chrono::duration<double, std::nano>(time) /
                                                       options_.speedup);
}

/// The controller's clock, while RSI has none.
void SimulatedCell::pass_time() {
  const drivers::TimePoint now = machine_.clock.now();
  const std::chrono::duration<double, std::nano> real = now - passed_;
  passed_ = now;
  if (!rsi_) controller_.advance(std::chrono::duration_cast<SimTime>(real * options_.speedup));
}

/// Makes the rest of the cell agree with the controller's new state.
void SimulatedCell::follow() {
  forward_outputs();
  restart_after_halt();
  for (; stops_seen_ < controller_.stops(); ++stops_seen_) {
    arm_.warm_up(now());
    arm_.move_to(controller_.axes());
    seen_.reset();
  }
  if (const auto session = controller_.rsi(); session && !rsi_) start_rsi(*session);
  next_change_.clear();
  const std::optional<SimTime> change = rsi_ ? std::nullopt : controller_.next_change();
  if (!change) return;
  const auto after = std::max<drivers::Duration>(shortened(*change), kShortest);
  next_change_.at(passed_ + after, [this] {
    pass_time();
    follow();
  });
}

void SimulatedCell::restart_after_halt() {
  const std::uint64_t halts = controller_.halts();
  if (std::exchange(halts_seen_, halts) != halts)
    operate_later(std::chrono::ceil<SimTime>(Seconds{scenario_.operator_s}),
                  {.kind = OperatorAct::Kind::Start});
}

void SimulatedCell::forward_outputs() {
  for (const std::string& channel : controller_.take_closed()) eki_.close(channel);
  for (const EkiPort& its : eki_ports_) eki_.listen(its.channel, controller_.is_open(its.channel));
  for (Controller::Document& document : controller_.take_documents())
    eki_.send(document.channel, std::move(document.text));
  for (const std::string& message : controller_.take_messages())
    std::fprintf(stderr, "pendant: %s\n", message.c_str());
}

void SimulatedCell::start_rsi(const Controller::OpenedRsi& session) {
  rsi_session_ = session.number;
  rsi::Context context = contexts_.at(session.context);
  for (const RsiParameter& parameter : session.parameters) set_parameter(context, parameter);
  const RsiSetup setup{.nominal = scenario_.rsi_arm.value_or(scenario_.nominal),
                       .ethernet = ethernet_,
                       .context = std::move(context),
                       .cycle = scenario_.cycle,
                       .servo = servo_setup(scenario_),
                       .hold_on = scenario_.hold_on,
                       .ignores_correction = scenario_.ignores_correction,
                       .consecutive_delay = scenario_.consecutive_delay};
  // A counter of the controller's milliseconds, so a new session is seen to be one.
  const auto ipoc =
      std::chrono::floor<std::chrono::milliseconds>(machine_.clock.now().time_since_epoch()).count();
  // The controller outlives its session.
  RsiClient client{setup, std::shared_ptr<RsiProgram>{std::shared_ptr<void>{}, &controller_},
                   static_cast<std::uint64_t>(ipoc)};
  const RsiSessionOptions options{.host = options_.rsi_host,
                                  .port = options_.rsi_port,
                                  .cycle = scenario_.cycle,
                                  .source_port = scenario_.rsi_source_port,
                                  .faults = rsi_faults(),
                                  .cycles_before = ended_sessions_.last_cycle};
  const auto ended = [this, number = session.number](RsiEnd end) {
    boost::asio::post(machine_.io, [=, this] { rsi_ended(number, end); });
  };
  const auto unknown_name = [this](const std::string& name) {
    boost::asio::post(machine_.io, [=, this] { report_unknown_name(name); });
  };
  const auto rejected = [this](const std::string& line) {
    boost::asio::post(machine_.io, [line] { std::fprintf(stderr, "%s\n", line.c_str()); });
  };
  rsi_ = machine_.start_rsi(options, std::move(client), {ended, unknown_name, rejected});
}

void SimulatedCell::rsi_ended(std::uint64_t session, RsiEnd end) {
  if (!rsi_ || session != rsi_session_) return;
  const std::unique_ptr<RsiSession> ended = std::exchange(rsi_, nullptr);
  ended->stop();
  ended_sessions_.add(ended->statistics());
  passed_ = machine_.clock.now();
  controller_.rsi_ended(session, end, ended->axes());
  if (end != RsiEnd::Off)
    operate_later(std::chrono::ceil<SimTime>(Seconds{scenario_.operator_s}),
                  {.kind = OperatorAct::Kind::Start});
  follow();
}

void SimulatedCell::operate_later(std::chrono::nanoseconds after, OperatorAct act) {
  alarms_.at(machine_.clock.now() + shortened(after), [this, act] {
    pass_time();
    controller_.operate(act);
    follow();
  });
}

void SimulatedCell::report_unknown_name(const std::string& name) {
  if (!reported_unknown_names_.insert(name).second) return;
  std::fprintf(stderr,
               "RSI: the replies have %s, which the RECEIVE list of the ethernet configuration does not: a "
               "controller ignores it without a word\n",
               name.c_str());
}

void SimulatedCell::put_reflector(const Eigen::Vector3d& p_FS_mm) {
  scenario_.p_FS_mm = p_FS_mm;
  arm_.put_reflector(p_FS_mm);
  sight_ = sight_of(scenario_);
  seen_.reset();
}

void SimulatedCell::exchange_arm(const RobotModel& truth, int serial) {
  scenario_.truth = truth;
  scenario_.robot_serial = serial;
  arm_ = TrueArm{arm_setup(scenario_), noise_random_.next()};
  sight_ = sight_of(scenario_);
  seen_.reset();
  controller_.exchange_arm(serial);
}

void SimulatedCell::jog(const JointVector& q) {
  pass_time();
  if (const auto jogged = controller_.jog(q); !jogged) throw std::invalid_argument{jogged.error()};
  follow();
}

Eigen::Vector3d SimulatedCell::measured(const Eigen::Vector3d& p_true_mm) {
  Eigen::Vector3d p_mm = noisy_reading(p_true_mm, noise_model(scenario_), noise_random_);
  if (extra_sigma_mm_ > 0) {
    for (double& coordinate : p_mm) coordinate += extra_sigma_mm_ * noise_random_.normal();
  }
  return p_mm;
}

}  // namespace truepose::sim
