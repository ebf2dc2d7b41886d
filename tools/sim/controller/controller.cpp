#include "tools/sim/controller/controller.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/math/angles.hpp"
#include "proto/rsi/gain_word.hpp"
#include "proto/text/device_text.hpp"
#include "tools/sim/krl/controller_declarations.hpp"

namespace truepose::sim {
namespace {

/// Of the interpolator.
constexpr std::chrono::milliseconds kCycle{4};

constexpr int kT1 = 1, kT2 = 2;  // operating modes

SimTime sim_time(Seconds t) { return std::chrono::ceil<SimTime>(t); }

/// The state as EKI and RSI report it to a PC.
eki::ProgramState reported_state(krl::ProgramState state) {
  switch (state) {
    case krl::ProgramState::Free:
      return eki::ProgramState::Free;
    case krl::ProgramState::Reset:
      return eki::ProgramState::Reset;
    case krl::ProgramState::Active:
      return eki::ProgramState::Active;
    case krl::ProgramState::Stopped:
      return eki::ProgramState::Stopped;
    case krl::ProgramState::Ended:
      break;
  }
  return eki::ProgramState::Ended;
}

ProgramMotion motion_of(const ControllerSetup& setup) {
  if (setup.nominal.joint_count() != 6) {
    throw std::invalid_argument("the simulated controller moves an arm of six axes, and '" +
                                setup.nominal.name + "' has " + std::to_string(setup.nominal.joint_count()));
  }
  auto motion = ProgramMotion::of(setup.nominal, setup.start);
  if (!motion) throw std::invalid_argument{motion.error()};
  return *std::move(motion);
}

}  // namespace

Controller::Controller(ControllerSetup setup)
    : setup_{std::move(setup)},
      motion_{motion_of(setup_)},
      actual_{setup_.start},
      set_points_{setup_.start},
      stood_at_{setup_.start},
      interrupted_at_{setup_.start} {
  for (const auto& [channel, text] : setup_.eki_files) {
    auto file = parse_eki_file(text);
    if (!file) throw std::invalid_argument{channel + ".xml: " + file.error()};
    channels_.emplace(channel, *std::move(file));
  }
  auto program = krl::load(
      {.declarations = std::string{controller_declarations()}, .pass_advance_run = setup_.pass_advance_run},
      setup_.programs);
  if (!program) throw std::invalid_argument{program.error().text()};
  program_ = std::make_unique<krl::Program>(*std::move(program));
  boot();
}

/// The submit program starts by itself; who switches the controller on starts the other.
void Controller::boot() {
  krl::Host& host = *this;
  memory_ = std::make_unique<krl::Memory>(*program_);
  robot_ = std::make_unique<krl::Interpreter>(*program_, *memory_, host, krl::InterpreterKind::Robot);
  submit_ = std::make_unique<krl::Interpreter>(*program_, *memory_, host, krl::InterpreterKind::Submit);
  variables_.clear();
  default_variables();
  selected_ = setup_.selected;
  for (const auto& [interpreter, routine] :
       {std::pair{submit_.get(), &setup_.submit}, {robot_.get(), &setup_.selected}}) {
    if (const auto selected = interpreter->select(*routine); !selected)
      throw std::invalid_argument{*routine + ": " + selected.error()};
    interpreter->start();
  }
  run_programs();
}

// ---- Time

void Controller::advance(SimTime by) {
  const std::lock_guard lock{mutex_};
  for (const SimTime end = time_ + by; time_ < end && !rsi_on_;) {
    SimTime step = end - time_;
    if (const auto motion = motion_.until_change(kCycle)) step = std::min(step, sim_time(*motion));
    if (const auto robot = robot_->next_change()) step = std::min(step, *robot - time_);
    step = std::clamp(step, SimTime{1}, end - time_);
    time_ += step;
    if (drives_on_) motion_.advance(step);
    actual_ = set_points_ = motion_.position();
    robot_->run(time_);
    if (motion_.is_standing() && differ(actual_, stood_at_)) {
      stood_at_ = actual_;
      ++stops_;
    }
  }
  submit_->run(time_);
}

std::optional<SimTime> Controller::next_change() const {
  const std::lock_guard lock{mutex_};
  std::optional<SimTime> next;
  const auto sooner = [&next](SimTime by) { next = std::min(next.value_or(by), std::max(by, SimTime{0})); };
  if (const auto motion = motion_.until_change(kCycle)) sooner(sim_time(*motion));
  for (const auto* interpreter : {robot_.get(), submit_.get()}) {
    if (const auto change = interpreter->next_change()) sooner(*change - time_);
  }
  return next;
}

/// At the time that has come.
void Controller::run_programs() {
  robot_->run(time_);
  submit_->run(time_);
}

void Controller::advance(Seconds cycle, const JointVector& actual, const JointVector& correction) {
  const std::lock_guard lock{mutex_};
  actual_ = actual;
  time_ += sim_time(cycle);
  for (const OperatorAct& act : std::exchange(acts_, {})) this->act(act);
  if (stream_path_ && time_ > stream_begins_ && robot_->state() == krl::ProgramState::Active) {
    stream_path_->advance(cycle, actual, correction);
    motion_.place(stream_path_->set_points());
  } else if (drives_on_) {
    motion_.advance(cycle);
  }
  run_programs();
  set_points_ = motion_.position();
  if (setup_.on_cycle && rsi_on_) report_cycle(correction);
  report_news();
}

void Controller::report_cycle(const JointVector& correction) const {
  constexpr int kGain = 2;  // as truepose_stream has it
  setup_.on_cycle({.time = time_,
                   .program = selected_,
                   .set_points = set_points_,
                   .correction = correction,
                   .actual = actual_,
                   .gain_percent = static_cast<int>(rsi::gain_of(sen_pint(kGain)).value_or(0)),
                   .motions_made = motion_.made(),
                   .is_standing = motion_.is_standing()});
}

/// After a cycle of RSI.
void Controller::report_news() {
  const bool has_halted = std::exchange(halts_reported_, halts_) != halts_;
  if (has_halted || !documents_.empty() || !closed_.empty() || !messages_.empty()) setup_.on_news();
}

int Controller::sen_pint(int index) const {
  const krl::Value* const value = variables_.find("$SEN_PINT", index);
  return value == nullptr ? 0 : std::get<std::int32_t>(*value);
}

void Controller::stand(Seconds cycle) {
  const std::lock_guard lock{mutex_};
  time_ += sim_time(cycle);
  for (const OperatorAct& act : std::exchange(acts_, {})) this->act(act);
  run_programs();
  report_news();
}

// ---- Ethernet KRL

std::map<std::string, std::uint16_t, std::less<>> Controller::eki_ports() const {
  std::map<std::string, std::uint16_t, std::less<>> ports;
  for (const auto& [name, channel] : channels_) ports.emplace(name, channel.file().port);
  return ports;
}

bool Controller::is_open(std::string_view channel) const {
  const std::lock_guard lock{mutex_};
  return channels_.find(channel)->second.is_open();
}

bool Controller::connect(std::string_view channel) {
  const std::lock_guard lock{mutex_};
  EkiChannel& its = channels_.find(channel)->second;
  if (!its.is_open() || its.is_connected()) return false;
  its.connect();
  if (its.file().alive_flag) raise(*its.file().alive_flag, true);
  if (!rsi_on_) run_programs();
  return true;
}

void Controller::disconnect(std::string_view channel) {
  const std::lock_guard lock{mutex_};
  EkiChannel& its = channels_.find(channel)->second;
  if (!its.is_connected()) return;
  its.disconnect();
  if (its.file().alive_flag) raise(*its.file().alive_flag, false);
  if (!rsi_on_) run_programs();
}

void Controller::receive(std::string_view channel, std::string_view document) {
  const std::lock_guard lock{mutex_};
  const auto flags = channels_.find(channel)->second.receive(document);
  if (!flags) {
    messages_.push_back("EKI: " + std::string{channel} + ": " + flags.error());
    return;
  }
  for (const int flag : *flags) raise(flag, true);
  if (!rsi_on_) run_programs();
}

std::vector<Controller::Document> Controller::take_documents() {
  const std::lock_guard lock{mutex_};
  return std::exchange(documents_, {});
}

std::vector<std::string> Controller::take_closed() {
  const std::lock_guard lock{mutex_};
  return std::exchange(closed_, {});
}

std::vector<std::string> Controller::take_messages() {
  const std::lock_guard lock{mutex_};
  return std::exchange(messages_, {});
}

void Controller::raise(int flag, bool to) { variables_.at("$FLAG", flag) = to; }

void Controller::drop(EkiChannel& channel) {
  const auto its = std::ranges::find_if(channels_, [&](const auto& one) { return &one.second == &channel; });
  if (channel.is_connected()) closed_.push_back(its->first);
  channel.clear();
  if (channel.file().alive_flag) raise(*channel.file().alive_flag, false);
}

// ---- People

void Controller::operate(OperatorAct act) {
  const std::lock_guard lock{mutex_};
  if (rsi_on_) {
    acts_.push_back(std::move(act));  // the clock's thread moves the arm
  } else {
    this->act(act);
    run_programs();
  }
}

void Controller::exchange_arm(int serial) {
  const std::lock_guard lock{mutex_};
  setup_.serial = serial;
}

std::expected<void, std::string> Controller::jog(const JointVector& q) {
  const std::lock_guard lock{mutex_};
  if (mode_ > kT2) return std::unexpected("jog: expected the key at T1 or T2");
  if (robot_->state() == krl::ProgramState::Active)
    return std::unexpected("jog: a program runs, stop it first");
  if (!rsi_on_) {
    motion_.place(q);
    return {};
  }
  // Under RSI the arm takes its time: a set point that jumps is no jogging.
  krl::Motion motion{.kind = krl::MotionKind::Ptp};
  krl::AxisTarget target;
  for (Eigen::Index i = 0; i < q.size(); ++i) target.axes[static_cast<std::size_t>(i)] = q[i] * kDegPerRad;
  motion.target = target;
  motion.velocity_percent.fill(100);
  motion_.cancel();
  return motion_.take(motion, true);
}

void Controller::act(const OperatorAct& act) {
  switch (act.kind) {
    case OperatorAct::Kind::Select:
      cancel_program();
      if (const auto selected = robot_->select(act.program); !selected) messages_.push_back(selected.error());
      selected_ = act.program;
      return;
    case OperatorAct::Kind::Start:
      if (!is_switched_on_) return;
      stop_message_ = false;
      drives_on_ = !emergency_stop_ && !gate_open_;
      if (drives_on_) robot_->start();
      return;
    case OperatorAct::Kind::Stop:
      return stop_program(false);
    case OperatorAct::Kind::Reset:
      stop_message_ = false;
      cancel_program();
      return robot_->reset();
    case OperatorAct::Kind::Deselect:
      cancel_program();
      robot_->deselect();
      return selected_.clear();
    case OperatorAct::Kind::EmergencyStop:
      emergency_stop_ = true;
      return power_off();
    case OperatorAct::Kind::ReleaseEmergencyStop:
      emergency_stop_ = false;
      return;
    case OperatorAct::Kind::OpenGate:
      gate_open_ = true;
      if (mode_ > kT2) power_off();  // in T1 and T2 people are inside
      return;
    case OperatorAct::Kind::CloseGate:
      gate_open_ = false;
      return;
    case OperatorAct::Kind::SetMode:
      stop_program(false);
      mode_ = act.number;
      return;
    case OperatorAct::Kind::SetOverride:
      static_cast<void>(write("$OV_PRO", std::nullopt, act.number));
      return;
    case OperatorAct::Kind::SwitchOff:
      cancel_program();
      robot_->deselect();
      submit_->deselect();
      for (auto& [name, channel] : channels_) drop(channel);
      drives_on_ = is_switched_on_ = false;
      return;
    case OperatorAct::Kind::SwitchOn:
      if (std::exchange(is_switched_on_, true)) return;
      drives_on_ = !emergency_stop_ && !gate_open_;
      return boot();
  }
}

void Controller::power_off() {
  drives_on_ = false;
  stop_program(true);
  motion_.halt();
}

void Controller::stop_program(bool by_message) {
  stop_message_ |= by_message;
  robot_->stop();
}

/// Ends what the program had open: its channels are deleted with it, and so is the signal flow.
void Controller::cancel_program() {
  robot_->stop();
  close_rsi();
  rsi_context_.reset();
  motion_.cancel();
  for (auto& [name, channel] : channels_) {
    if (!channel.file().of_submit) drop(channel);
  }
  for (const char* variable : {"$TOOL", "$BASE", "$ACT_TOOL", "$ACT_BASE"}) variables_.erase(variable);
}

// ---- The arm

JointVector Controller::axes() const {
  const std::lock_guard lock{mutex_};
  return actual_;
}

bool Controller::is_moving() const {
  const std::lock_guard lock{mutex_};
  return stream_path_ || !motion_.is_standing();
}

std::uint64_t Controller::moves() const {
  const std::lock_guard lock{mutex_};
  return motion_.moved();
}

std::uint64_t Controller::stops() const {
  const std::lock_guard lock{mutex_};
  return stops_;
}

Controller::Program Controller::program() const {
  const std::lock_guard lock{mutex_};
  return {.name = selected_, .state = reported_state(robot_->state()), .line = robot_->line()};
}

std::uint64_t Controller::halts() const {
  const std::lock_guard lock{mutex_};
  return halts_;
}

std::expected<void, std::string> Controller::move(const krl::Motion& motion) {
  return motion_.take(motion, mode_ == kT1);
}

/// What a program writes is Latin-1.
void Controller::show(const krl::Message& message) { messages_.push_back(text::device_text(message.text)); }

void Controller::cancel() {
  motion_.cancel();
  in_movecorr_ = false;
  stream_path_.reset();
}

// ---- RSI

std::optional<Controller::OpenedRsi> Controller::rsi() const {
  const std::lock_guard lock{mutex_};
  if (!rsi_on_) return std::nullopt;
  return OpenedRsi{rsi_sessions_, *rsi_context_, rsi_parameters_};
}

void Controller::rsi_ended(std::uint64_t session, RsiEnd end, const JointVector& actual) {
  const std::lock_guard lock{mutex_};
  if (session != rsi_sessions_) return;
  actual_ = actual;
  for (const OperatorAct& act : std::exchange(acts_, {})) this->act(act);
  if (rsi_on_) {
    close_rsi();
    rsi_context_.reset();
  }
  if (end == RsiEnd::Off) return run_programs();
  messages_.emplace_back(
      end == RsiEnd::Timeout
          ? "KSS29002: Object ETHERNET1 returns error RSITimeout: too many cycles without a valid reply"
      : end == RsiEnd::PoseMonitor
          ? "KSS29000: POSCORR: overall correction exceeded: RSI is stopped"
          : "AXISCORRMON: the correction of an axis is larger than the monitor allows");
  stop_program(true);
  run_programs();
}

bool Controller::drives_on() const {
  const std::lock_guard lock{mutex_};
  return drives_on_;
}

/// In #IPO corrections apply to LIN and CIRC alone (KST RSI 3.3, 4.1, as quoted by a program that ran).
bool Controller::corrects() const {
  const std::lock_guard lock{mutex_};
  return !rsi_ipo_ || !motion_.is_ptp();
}

bool Controller::is_relative() const {
  const std::lock_guard lock{mutex_};
  return rsi_relative_;
}

FlowSources Controller::sources() const {
  const std::lock_guard lock{mutex_};
  const auto read = [this](int index) {
    const std::lock_guard reading{mutex_};
    return sen_pint(index);
  };
  const auto bit = [this](std::string_view variable) {
    return [this, variable](int index) {
      const std::lock_guard reading{mutex_};
      const krl::Value* const value = variables_.find(variable, index);
      return value != nullptr && *value == krl::Value{true};
    };
  };
  rsi::Axes axes_deg;
  std::ranges::transform(actual_, axes_deg.begin(), [](double rad) { return rad * kDegPerRad; });
  const auto read_real = [this](int index) {
    const std::lock_guard reading{mutex_};
    const krl::Value* const value = variables_.find("$SEN_PREA", index);
    const double* const real = value == nullptr ? nullptr : std::get_if<double>(value);
    return real == nullptr ? 0 : *real;
  };
  return {.sen_pint = read,
          .sen_prea = read_real,
          .in = bit("$IN"),
          .out = bit("$OUT"),
          .axes_deg = axes_deg,
          .time_s = std::chrono::duration<double>(time_).count(),
          .mode = mode_,
          .program_state = static_cast<int>(reported_state(robot_->state())),
          .override_percent = std::get<std::int32_t>(*variables_.find("$OV_PRO")),
          .base = frame_in("$BASE").value_or(Eigen::Isometry3d::Identity()),
          .tool = frame_in("$TOOL").value_or(Eigen::Isometry3d::Identity())};
}

void Controller::take(const FlowEffects& effects) {
  const std::lock_guard lock{mutex_};
  for (const auto& [index, value] : effects.sen_pint) variables_.at("$SEN_PINT", index) = value;
  for (const auto& [index, value] : effects.sen_prea) variables_.at("$SEN_PREA", index) = value;
  for (const auto& [index, value] : effects.outputs) variables_.at("$OUT", index) = value;
  for (const auto& [index, value] : effects.analog) variables_.at("$ANOUT", index) = value;
  if (effects.leaves_movecorr) {
    in_movecorr_ = false;
    stream_path_.reset();
  }
}

bool Controller::is_on() const {
  const std::lock_guard lock{mutex_};
  return rsi_on_;
}

}  // namespace truepose::sim
