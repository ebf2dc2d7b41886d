#include "drivers/kuka/eki_robot.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

#include "core/math/angles.hpp"
#include "core/planted_bug.hpp"
#include "drivers/condition.hpp"
#include "drivers/deadline.hpp"
#include "drivers/kuka/eki_channel.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

constexpr auto kStandstillPoll = 50ms;
constexpr Duration kAgain = 50ms, kDrops = 2s;  // a controller that has not yet seen its last client go
constexpr double kArrivalTolerance_rad = 0.2 * kRadPerDeg;  // the KRL program's own is 0.1 deg

/// Random, so that a daemon that was restarted never repeats the ids of the one before; half of the range is
/// left.
std::int32_t first_id(const RandomBytes& random) {
  std::array<unsigned char, sizeof(std::uint32_t)> drawn{};
  random(drawn);
  return static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(drawn) & 0x3fffffff);
}

std::string reason(int error) {
  switch (static_cast<eki::AckError>(error)) {
    case eki::AckError::None:
      return "no reason given";
    case eki::AckError::OutOfRange:
      return "a target axis lies outside the software limits";
    case eki::AckError::UnknownType:
      return "the robot program does not know this command";
    case eki::AckError::Stopped:
      return "a stop is active";
    case eki::AckError::NotInPosition:
      return "the axes did not reach the target";
    case eki::AckError::LinkLost:
      return "the connection was lost during the motion";
    case eki::AckError::Rsi:
      return "RSI could not be opened";
  }
  return "controller message " + std::to_string(error);
}

std::string why_not_ready(const eki::State& state) {
  const bool needs_gate = state.mode == eki::OperatingMode::Aut || state.mode == eki::OperatingMode::Ext;
  if (!state.no_emergency_stop && !planted("an emergency stop is ready")) return "emergency stop";
  if (needs_gate && !state.gate_closed && !planted("an open gate is ready")) return "safety gate open";
  if (!state.drives_ready) return "drives off";
  if (state.stop_message) return "a stop message is pending on the pendant";
  if (state.program != eki::ProgramState::Active) return "the robot program is not running";
  // $ACT_TOOL and $ACT_BASE are -1 until one has been set, then 0 for none.
  if (state.tool.value_or(0) > 0)
    return "tool " + std::to_string(*state.tool) + " is active, the flange (0) is needed";
  if (state.base.value_or(0) > 0)
    return "base " + std::to_string(*state.base) + " is active, the robot's own (0) is needed";
  return {};
}

JointVector to_joints(const eki::Axes& axes_rad, int count) {
  return Eigen::Map<const JointVector>(axes_rad.data(), count);
}

bool same_order(eki::Command a, const eki::Command& b) {
  a.id = b.id;
  return a == b;
}

}  // namespace

/// The States that calls under way wait for, by id. state() and stop() share one connection: whichever reads
/// hands the other its answer.
class KukaEkiRobot::Answers {
 public:
  explicit Answers(const asio::any_io_executor& executor) : changed_{executor} {}

  /// Waits for the State that answers `id`. One call at a time reads from the channel.
  asio::awaitable<std::expected<eki::State, RobotError>> wait(EkiChannel& channel, Clock& clock,
                                                              std::int32_t id, TimePoint deadline) {
    const Expectation expectation{*this, id};
    for (;;) {
      if (const std::optional<eki::State>& state = awaited_[id]) co_return *state;
      if (reading_) {
        const bool woken = co_await before(clock, deadline, change(changes_));
        if (!woken)
          co_return std::unexpected(RobotError{RobotFault::Timeout, "no confirmation before the deadline"});
        continue;
      }
      const Reading reading{*this};
      const auto message = co_await channel.receive(deadline);
      if (!message) co_return std::unexpected(message.error());
      const auto* state = std::get_if<eki::State>(&*message);
      if (!state) continue;
      const auto awaited = awaited_.find(state->id);
      if (awaited != awaited_.end()) awaited->second = *state;
    }
  }

 private:
  struct Expectation {
    Expectation(Answers& owner, std::int32_t awaited) : answers{owner}, id{awaited} { answers.awaited_[id]; }
    ~Expectation() { answers.awaited_.erase(id); }
    Answers& answers;
    std::int32_t id;
  };

  struct Reading {
    explicit Reading(Answers& owner) : answers{owner} { answers.reading_ = true; }
    ~Reading() {
      answers.reading_ = false;
      ++answers.changes_;
      answers.changed_.notify();
    }
    Answers& answers;
  };

  /// Returns when another call has stopped reading since `seen` was the number of changes.
  asio::awaitable<void> change(unsigned seen) {
    if (changes_ == seen) co_await changed_.wait();
  }

  Condition changed_;
  std::map<std::int32_t, std::optional<eki::State>> awaited_;
  bool reading_ = false;
  unsigned changes_ = 0;
};

KukaEkiRobot::KukaEkiRobot(asio::any_io_executor executor, Clock& clock, KukaEkiOptions options)
    : clock_{clock},
      options_{std::move(options)},
      motion_{std::make_unique<EkiChannel>(options_.stream(executor), clock, "CellLink",
                                           "the robot program truepose_motion", options_.host,
                                           options_.motion_port, options_.motion_tap)},
      state_{std::make_unique<EkiChannel>(options_.stream(executor), clock, "CellState",
                                          "the state server (sps.sub)", options_.host, options_.state_port,
                                          options_.state_tap)},
      answers_{std::make_unique<Answers>(executor)},
      last_id_{first_id(options_.random)} {
  assert(options_.joint_count >= 1 && options_.joint_count <= static_cast<int>(eki::Axes{}.size()));
}

KukaEkiRobot::~KukaEkiRobot() = default;

bool KukaEkiRobot::linked() const { return motion_->connected() || state_->connected(); }

void KukaEkiRobot::disconnect() noexcept {
  motion_->close();
  state_->close();
}

// A stop that was cut off by a lost connection would refuse every command.
asio::awaitable<std::expected<RobotIdentity, RobotError>> KukaEkiRobot::connect(TimePoint deadline) {
  if (planted("connecting does not release a stop")) return inspect(deadline);
  return open(eki::ControlOp::ReleaseStop, deadline);
}

asio::awaitable<std::expected<RobotIdentity, RobotError>> KukaEkiRobot::inspect(TimePoint deadline) {
  return open(eki::ControlOp::AskState, deadline);
}

asio::awaitable<std::expected<RobotIdentity, RobotError>> KukaEkiRobot::open(eki::ControlOp op,
                                                                             TimePoint deadline) {
  disconnect();
  const auto answered = co_await open_state(op, deadline);  // shows that the state server answers, too
  if (!answered) co_return std::unexpected(answered.error());
  const auto hello = co_await open_motion(deadline);
  if (!hello) co_return std::unexpected(hello.error());
  if (hello->version != eki::kProtocolVersion) {
    disconnect();
    co_return std::unexpected(RobotError{
        RobotFault::Protocol, "the controller's truepose programs speak version " +
                                  std::to_string(hello->version) + ", this daemon speaks version " +
                                  std::to_string(eki::kProtocolVersion) + ": install the matching ones"});
  }
  co_return RobotIdentity{hello->model, hello->serial, hello->kss_version};
}

/// Connects, and has the first control answered.
asio::awaitable<std::expected<eki::State, RobotError>> KukaEkiRobot::open_state(eki::ControlOp op,
                                                                                TimePoint deadline) {
  for (const TimePoint last_try = clock_.now() + kDrops;;) {
    const auto linked = co_await state_->connect(deadline);
    if (!linked) co_return std::unexpected(linked.error());
    const auto state = co_await control(op, deadline);
    if (state) co_return state;
    const bool again = co_await drops_once_more(state.error(), last_try);
    if (!again) co_return state;
  }
}

asio::awaitable<std::expected<eki::Hello, RobotError>> KukaEkiRobot::open_motion(TimePoint deadline) {
  for (const TimePoint last_try = clock_.now() + kDrops;;) {
    const auto linked = co_await motion_->connect(deadline);
    if (!linked) co_return std::unexpected(linked.error());
    const auto hello = co_await greeting(deadline);
    if (hello) co_return hello;
    const bool again = co_await drops_once_more(hello.error(), last_try);
    if (!again) co_return hello;
  }
}

/// Whether a client that was taken and dropped before a word may try again; after a while.
asio::awaitable<bool> KukaEkiRobot::drops_once_more(const RobotError& error, TimePoint last_try) {
  const TimePoint next = clock_.now() + kAgain;
  const bool again = error.fault == RobotFault::Disconnected && next < last_try;
  if (again) co_await clock_.sleep_until(next);
  co_return again;
}

asio::awaitable<std::expected<eki::Hello, RobotError>> KukaEkiRobot::greeting(TimePoint deadline) {
  for (;;) {
    const auto message = co_await motion_->receive(deadline);
    if (!message) co_return std::unexpected(message.error());
    if (const auto* hello = std::get_if<eki::Hello>(&*message)) co_return *hello;
  }
}

asio::awaitable<std::expected<eki::State, RobotError>> KukaEkiRobot::control(eki::ControlOp op,
                                                                             TimePoint deadline) {
  const eki::Control control{next_id(), op, 0};
  const auto sent = co_await state_->send(control, deadline);
  if (!sent) co_return std::unexpected(sent.error());
  const auto state = co_await answers_->wait(*state_, clock_, control.id, deadline);
  co_return state;
}

RobotState KukaEkiRobot::robot_state(const eki::State& reported) const {
  const std::array<double, 6>& pose = reported.pose;
  RobotState state;
  state.q = to_joints(reported.axes_rad, options_.joint_count);
  state.X_BF_reported = pose_from_kuka({pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5]});
  state.why_not_ready = why_not_ready(reported);
  state.ready = state.why_not_ready.empty();
  state.moving = reported.moving || !reported.in_position;
  state.override_percent = reported.override_percent;
  state.mode = name(reported.mode);
  state.program = name(reported.program);
  state.emergency_stop = !reported.no_emergency_stop;
  state.gate_open = !reported.gate_closed;
  if (reported.tool.value_or(0) > 0) state.tool = reported.tool;
  if (reported.tool.value_or(-1) >= 0) state.tool_frame = reported.tool_frame;
  if (reported.base.value_or(-1) >= 0) state.base_frame = reported.base_frame;
  if (reported.load_kg.value_or(-1) >= 0) state.load_kg = reported.load_kg;
  if (reported.serial) state.serial = std::to_string(*reported.serial);
  return state;
}

asio::awaitable<std::expected<RobotState, RobotError>> KukaEkiRobot::state(TimePoint deadline) {
  const auto reported = co_await control(eki::ControlOp::AskState, deadline);
  if (!reported) co_return std::unexpected(reported.error());
  co_return robot_state(*reported);
}

asio::awaitable<std::expected<RobotState, RobotError>> KukaEkiRobot::look(TimePoint deadline) {
  if (state_->connected()) {
    auto seen = co_await state(deadline);
    co_return seen;
  }
  const auto reported = co_await open_state(eki::ControlOp::AskState, deadline);
  if (!reported) co_return std::unexpected(reported.error());
  co_return robot_state(*reported);
}

asio::awaitable<std::expected<JointVector, RobotError>> KukaEkiRobot::move(MoveCommand move,
                                                                           TimePoint deadline) {
  if (move.q.size() != options_.joint_count || !move.q.allFinite()) {
    co_return std::unexpected(
        RobotError{RobotFault::Refused,
                   "the target needs " + std::to_string(options_.joint_count) + " finite joint positions"});
  }
  eki::Command command;
  command.type = eki::CommandType::Ptp;
  command.velocity_percent = static_cast<int>(std::lround(std::clamp(move.speed_percent, 1.0, 100.0)));
  command.settle_ms = static_cast<int>(std::clamp<std::int64_t>(move.settle.count(), 0, 60000));
  std::copy_n(move.q.data(), move.q.size(), command.axes_rad.begin());

  const auto ack = co_await run(command, eki::AckState::InPosition, deadline);
  if (!ack) co_return std::unexpected(ack.error());
  if (!ack->axes_rad) {
    co_return std::unexpected(RobotError{
        RobotFault::Protocol, "the controller confirmed the motion without its axes (Ack has no Ax)"});
  }
  // The answer to a repeated command is the old one: the arm may have been moved by hand since.
  const JointVector q = to_joints(*ack->axes_rad, options_.joint_count);
  const double away_rad = (q - move.q).cwiseAbs().maxCoeff();
  if (away_rad > kArrivalTolerance_rad) {
    co_return std::unexpected(RobotError{
        RobotFault::Aborted,
        "the motion ended " + std::to_string(away_rad * kDegPerRad) + " deg away from its target"});
  }
  co_return q;
}

asio::awaitable<std::expected<void, RobotError>> KukaEkiRobot::start_stream_program(TimePoint deadline) {
  eki::Command command;
  command.type = eki::CommandType::StartRsi;
  const auto ack = co_await run(command, eki::AckState::Moving, deadline);
  if (!ack) co_return std::unexpected(ack.error());
  co_return std::expected<void, RobotError>{};
}

/// Sends the command and waits until its Ack says `until` or that it has ended.
asio::awaitable<std::expected<eki::Ack, RobotError>> KukaEkiRobot::run(eki::Command command,
                                                                       eki::AckState until,
                                                                       TimePoint deadline) {
  if (planted("a repeated motion order has a new number")) unfinished_.reset();
  command.id = unfinished_ && same_order(command, *unfinished_) ? unfinished_->id : next_id();
  unfinished_ = command;
  const auto sent = co_await motion_->send(command, deadline);
  if (!sent) co_return std::unexpected(sent.error());
  for (;;) {
    const auto message = co_await motion_->receive(deadline);
    if (!message) co_return std::unexpected(message.error());
    const auto* ack = std::get_if<eki::Ack>(&*message);
    if (!ack || ack->id != command.id) continue;  // of an earlier command, or repeated by EKI
    switch (ack->state) {
      case eki::AckState::Accepted:
        break;
      case eki::AckState::Moving:
        if (until != eki::AckState::Moving) break;
        [[fallthrough]];
      case eki::AckState::InPosition:
        unfinished_.reset();
        co_return *ack;
      case eki::AckState::Rejected:
        unfinished_.reset();
        co_return std::unexpected(
            RobotError{RobotFault::Refused, "the controller rejected the command: " + reason(ack->error)});
      case eki::AckState::Aborted:
        unfinished_.reset();
        co_return std::unexpected(
            RobotError{RobotFault::Aborted, "the controller aborted the command: " + reason(ack->error)});
    }
  }
}

/// Over a new connection where there is none: a call that is cancelled in its midst closes it, and whoever
/// cancels is likely to want the arm to stop.
asio::awaitable<std::expected<eki::State, RobotError>> KukaEkiRobot::order_stop(TimePoint deadline) {
  if (state_->connected()) {
    auto answered = co_await control(eki::ControlOp::Stop, deadline);
    if (answered || answered.error().fault != RobotFault::Disconnected) co_return answered;
  }
  auto answered = co_await open_state(eki::ControlOp::Stop, deadline);
  co_return answered;
}

asio::awaitable<std::expected<void, RobotError>> KukaEkiRobot::stop(TimePoint deadline) {
  auto state = co_await order_stop(deadline);
  while (state && (state->moving || !state->in_position)) {
    const TimePoint next = clock_.now() + kStandstillPoll;
    if (next >= deadline) {
      co_return std::unexpected(
          RobotError{RobotFault::Timeout, "the arm still moves after the order to stop"});
    }
    co_await clock_.sleep_until(next);
    state = co_await control(eki::ControlOp::AskState, deadline);
  }
  // Only now may the next command be taken: one that was on its way when we stopped has been refused.
  if (state) state = co_await control(eki::ControlOp::ReleaseStop, deadline);
  if (!state) co_return std::unexpected(state.error());
  co_return std::expected<void, RobotError>{};
}

}  // namespace truepose::drivers
