#include "tests/daemon/production_cell.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/published_arm.hpp"
#include "proto/rsi/gain_word.hpp"
#include "tools/sim/krl/controller_declarations.hpp"
#include "tools/sim/system_files.hpp"

namespace truepose::daemon {
namespace {

namespace krl = sim::krl;
using krl::Parts;
using krl::Value;
using test::Plant;

constexpr std::chrono::milliseconds kCycle{4};
constexpr int kTimeout = 100;  // cycles, of the ETHERNET object
constexpr int kSettled = 20;   // cycles after a motion, in the program's wait behind it
constexpr std::uint64_t kMostCyclesOfAProgram = 150'000;
constexpr double kCyclesOfAProgram = 22'000;       // about
constexpr std::uint32_t kController = 0xC0A82C01;  // 192.168.44.1

/// The shipped stream programs and a cell's: its own $config.dat takes the place of the controller's.
std::vector<krl::Source> sources_with(const std::string& program) {
  const std::filesystem::path root = TRUEPOSE_SOURCE_DIR, corpus = root / "tests/proto/krl_corpus/stream";
  std::vector<std::filesystem::path> files{root / "config/kuka/krl/truepose_stream.src",
                                           root / "config/kuka/krl/truepose_stream.dat"};
  if (program == "GLUING") {
    files.insert(files.end(), {root / "config/scenarios/gluing.src", root / "config/scenarios/gluing.dat"});
  } else {
    files.insert(files.end(),
                 {corpus / (program + ".src"), corpus / (program + ".dat"), corpus / "$config.dat"});
  }
  std::vector<krl::Source> sources;
  for (const std::filesystem::path& file : files)
    sources.push_back({file.filename(), config::read_text_file(file)});
  for (const EmbeddedText& file : sim::system_files()) {
    const std::string name = std::filesystem::path{file.name}.filename();
    if (name != "config.dat") sources.push_back({name, std::string{file.text}});
    if (name == "config.dat" && program == "GLUING")
      sources.push_back({"$config.dat", std::string{file.text}});
  }
  return sources;
}

krl::Program loaded(AdvanceRun advance_run, const std::string& program) {
  auto loaded = krl::load({.declarations = std::string{sim::controller_declarations()},
                           .pass_advance_run = advance_run == AdvanceRun::PassesVariables
                                                   ? std::vector<std::string>{"$SEN_PINT", "$AXIS_ACT_MEAS"}
                                                   : std::vector<std::string>{}},
                          sources_with(program));
  if (!loaded) throw std::runtime_error{loaded.error().text()};
  return *std::move(loaded);
}

rsi::EthernetConfig shipped_config() {
  return rsi::parse_ethernet_config(config::read_text_file(std::string{TRUEPOSE_SOURCE_DIR} +
                                                           "/config/kuka/rsi/truepose_rsi_ethernet.xml"))
      .value();
}

JointVector upright() { return (JointVector(6) << 0, -80, 105, 5, 60, 0).finished() * kRadPerDeg; }

Plant::Axes deg_of(const JointVector& q) {
  Plant::Axes deg{};
  for (std::size_t i = 0; i < 6; ++i) deg[i] = q[static_cast<Eigen::Index>(i)] * kDegPerRad;
  return deg;
}

JointVector joints_of(const Plant::Axes& deg) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(deg.data()) * kRadPerDeg;
}

double greatest(const Plant::Axes& axes) {
  double most = 0;
  for (const double axis : axes) most = std::max(most, std::abs(axis));
  return most;
}

std::string key(std::string_view name, std::optional<int> index) {
  return std::string{name} + (index ? "[" + std::to_string(*index) + "]" : "");
}

}  // namespace

void TcpErrors::add(double mm) {
  mean_mm += (mm - mean_mm) / ++points;
  max_mm = std::max(max_mm, mm);
}

ProductionCell::ProductionCell(std::uint64_t seed, const Troubles& troubles, AdvanceRun advance_run,
                               const std::string& program)
    : random_{seed},
      troubles_{troubles},
      nominal_{published_arm()},
      real_{with_published_errors(published_arm())},
      config_{shipped_config()},
      codec_{config_},
      motion_{sim::ProgramMotion::of(nominal_, upright()).value()},
      plant_{{.dead_time_ms = 8, .lag_ms = 15, .timeout_cycles = kTimeout}},
      program_{loaded(advance_run, program)},
      memory_{program_},
      interpreter_{program_, memory_, *this, krl::InterpreterKind::Robot},
      actual_{upright()} {
  variables_["$NULLFRAME"] = Parts(6, Value{0.0});
  variables_["$STOPMESS"] = variables_["$FLAG[77]"] = false;
  variables_["$IPO_MODE"] = krl::Literal{"BASE"};
  start_daemon();
  if (const auto selected = interpreter_.select(program); !selected)
    throw std::runtime_error{selected.error()};
}

ProductionCell::~ProductionCell() = default;

Production ProductionCell::shift(int programs) {
  interpreter_.start();
  std::uint64_t begun = 0;
  for (programs_left_ = programs; shift_.programs < programs; programs_left_ = programs - shift_.programs) {
    cycle();
    if (interpreter_.fault()) throw std::runtime_error{interpreter_.fault()->text()};
    if (shift_.cycles - begun > kMostCyclesOfAProgram) throw std::runtime_error{stuck()};
    if (interpreter_.state() != krl::ProgramState::Ended) continue;
    ++shift_.programs;
    begun = shift_.cycles;
    restart_program();
  }
  shift_.never_came = troubles_;
  return shift_;
}

std::string ProductionCell::stuck() const {
  const StreamStatus status = stream_ ? stream_->status() : StreamStatus{};
  return "program " + std::to_string(shift_.programs + 1) + " does not come to its end: line " +
         std::to_string(interpreter_.line()) + ", gain " + std::to_string(rsi::gain_of(gain_).value_or(0)) +
         ", stream " + std::string{name(status.state)} + " " + reason(status) + ", RSI " +
         (rsi_on_ ? "on" : "off");
}

/// One interpolation cycle of the controller.
void ProductionCell::cycle() {
  ++shift_.cycles;
  now_ += kCycle;
  befall();
  interpreter_.run(now_.time_since_epoch());
  const JointVector& commanded = motion_.advance(std::chrono::duration<double>{kCycle});
  actual_ = commanded;
  if (rsi_on_) {
    if (const auto sent = plant_.begin_cycle(deg_of(commanded))) {
      actual_ = joints_of(sent->aipos_deg);
      exchange(*sent);
    }
    const Plant::State state = plant_.end_cycle();
    variables_["$SEN_PINT[2]"] = gain_;  // MAP2SEN_PINT, with what HOLDON keeps
    shift_.max_step_deg = std::max(shift_.max_step_deg, state.step_deg);
    shift_.largest_deg = std::max(shift_.largest_deg, greatest(state.in_force_deg));
    if (!state.alive) {  // KSS29002: somebody resets the program and starts it again
      ++shift_.timeouts;
      close_rsi();
      restart_program();
    }
  }
  judge();
}

// ---- The daemon ----

void ProductionCell::start_daemon() {
  stream_memory_ = page_.open();
  StreamOptions options = StreamOptions::of(config::CellConfig{});
  options.timeout_cycles = kTimeout;
  options.peer = kController;
  options.listening_since = now_;
  stream_ = StreamCycle::create(nominal_, config_, options, stream_memory_.get()).value();
  stream_->use_model(real_, 1);
  stream_->arm();
}

void ProductionCell::end_daemon(int cycles) {
  stream_.reset();
  stream_memory_.reset();
  daemon_down_ = cycles;
}

void ProductionCell::exchange(const Plant::Sent& sent) {
  if (burst_ == 0 && random_.uniform() * 10 < troubles_.loss)
    burst_ = 1 + static_cast<int>(random_.uniform() * 19);
  const bool lost = burst_ > 0 && burst_-- > 0;
  if (!stream_ || (lost && random_.uniform() < 0.5)) return;
  const std::string_view reply = stream_->answer({frame(sent), {kController, sent.source_port}, now_});
  stream_->finish({.received = now_, .taken = now_, .ready = now_, .sent = now_, .replied = !reply.empty()});
  if (const StreamStatus status = stream_->status();
      status.fault != StreamFault::None && shift_.fault.empty())
    shift_.fault = reason(status);
  if (reply.empty() || lost) return;
  const rsi::SensorFrame answer = codec_.decode(reply).value();
  Plant::Axes correction_deg;
  for (std::size_t i = 0; i < 6; ++i) correction_deg[i] = (*answer.axis_correction_rad)[i] * kDegPerRad;
  if (!plant_.take_reply(answer.ipoc, correction_deg)) return;
  gain_ = static_cast<std::int32_t>(rsi::gain_word(answer.gain.value_or(0), answer.ipoc));
}

std::string ProductionCell::frame(const Plant::Sent& sent) {
  rsi::RobotFrame frame = robot_frame(sent);
  const Eigen::Isometry3d tcp = inverse_of(frame_of("$BASE")) *
                                forward_kinematics(nominal_, joints_of(sent.aipos_deg)) * frame_of("$TOOL");
  const Eigen::Vector3d abc = kuka_abc_deg(tcp.linear());
  frame.rist = rsi::CartesianPose{
      tcp.translation().x(), tcp.translation().y(), tcp.translation().z(), abc.x(), abc.y(), abc.z()};
  const auto* ask = std::get_if<std::int32_t>(&variables_["$SEN_PINT[1]"]);
  frame.program = {.ask = ask ? *ask : 0,
                   .state = interpreter_.state() == krl::ProgramState::Active ? rsi::kProgramActive : 4};
  std::array<char, rsi::kMaxFrameBytes> buffer;
  return std::string{rsi::encode_robot_frame(frame, buffer, 4).value()};
}

// ---- What befalls ----

/// Whether one of those that are left happens in this cycle.
bool ProductionCell::due(int& left) {
  constexpr double kSoon = 0.05;  // programs: what has not come by the last one comes then
  const double programs = std::max(kSoon, programs_left_ - 1);
  if (left == 0 || random_.uniform() * programs * kCyclesOfAProgram >= left) return false;
  --left;
  return true;
}

void ProductionCell::befall() {
  if (daemon_down_ > 0 && --daemon_down_ == 0) start_daemon();
  if (stopped_ > 0 && --stopped_ == 0) interpreter_.start();
  if (stream_ && due(troubles_.daemon_ends)) end_daemon(troubles_.daemon_ends % 2 ? 40 : 3 * kTimeout);
  const bool runs = stopped_ == 0 && interpreter_.state() == krl::ProgramState::Active;
  if (runs && (due(troubles_.stops) || due(troubles_.emergency_stops))) {
    interpreter_.stop();
    stopped_ = 250 + static_cast<int>(random_.uniform() * 1500);
  }
  if (runs && due(troubles_.controller_restarts)) {
    close_rsi();
    restart_program();
  }
}

void ProductionCell::restart_program() {
  stopped_ = 0;
  motion_.cancel();
  interpreter_.reset();
  interpreter_.start();
}

void ProductionCell::open_rsi() {
  ++shift_.sessions;
  constexpr int kPause = 10;  // cycles
  plant_.restart_session(
      {.pause_cycles = kPause,
       .ipoc = 4'208'163 + 4 * (shift_.cycles + kPause),  // milliseconds continue meanwhile
       .source_port = {},
       .arm_settled = true});
  rsi_on_ = true;
  gain_ = 0;
}

void ProductionCell::close_rsi() { rsi_on_ = false; }

/// Where the TCP stands at a point of the program, and where it would without the stream.
void ProductionCell::judge() {
  if (motion_.made() != made_before_) {
    made_before_ = motion_.made();
    judge_in_ = kSettled;
    return;
  }
  if (judge_in_ == 0 || --judge_in_ > 0 || !rsi_on_ || stopped_ > 0 || !motion_.is_standing()) return;
  if (!stream_ || rsi::gain_of(gain_) != 100) {
    ++shift_.points_without_it;
    return;
  }
  const Eigen::Isometry3d tool = frame_of("$TOOL");
  const auto tcp_mm = [&](const RobotModel& arm, const JointVector& q) {
    return Eigen::Vector3d{(forward_kinematics(arm, q) * tool).translation()};
  };
  const Eigen::Vector3d wanted = tcp_mm(nominal_, motion_.position());
  shift_.with.add((tcp_mm(real_, actual_) - wanted).norm());
  shift_.without.add((tcp_mm(real_, motion_.position()) - wanted).norm());
}

// ---- The controller, as the program sees it ----

Eigen::Isometry3d ProductionCell::frame_of(const char* variable) {
  const auto* parts = std::get_if<Parts>(&variables_[variable]);
  if (parts == nullptr) return Eigen::Isometry3d::Identity();
  const auto at = [&](std::size_t i) { return krl::number_of((*parts)[i]); };
  return pose_from_kuka({at(0), at(1), at(2)}, {at(3), at(4), at(5)});
}

Value ProductionCell::read(const krl::Variable& variable, std::optional<int> index) {
  if (variable.name == "$AXIS_ACT_MEAS") {
    Parts axes(12, Value{0.0});
    for (std::size_t i = 0; i < 6; ++i) axes[i] = actual_[static_cast<Eigen::Index>(i)] * kDegPerRad;
    return axes;
  }
  const auto found = variables_.find(key(variable.name, index));
  return found == variables_.end() ? Value{} : found->second;
}

std::expected<void, std::string> ProductionCell::write(std::string_view name, std::optional<int> index,
                                                       const Value& value) {
  variables_[key(name, index)] = value;
  return {};
}

std::expected<krl::CallResult, std::string> ProductionCell::call(krl::ExternalCall& call) {
  if (call.name == "MSGNOTIFY") say(text_of(call.arguments[0]));
  if (call.name == "RSI_CREATE") call.arguments[1] = 1;
  if (call.name == "RSI_ON") open_rsi();
  if (call.name == "RSI_OFF") {
    shift_.left_deg = std::max(shift_.left_deg, greatest(plant_.in_force_deg()));
    close_rsi();
  }
  if (call.name == "RSI_RESET") close_rsi();
  return krl::CallResult{.value = 0};
}

std::expected<void, std::string> ProductionCell::move(const krl::Motion& motion) {
  return motion_.take(motion);
}

void ProductionCell::say(const std::string& text) {
  if (std::ranges::find(shift_.messages, text) == shift_.messages.end()) shift_.messages.push_back(text);
}

}  // namespace truepose::daemon
