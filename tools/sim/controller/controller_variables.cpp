// The part of Controller that answers for system variables.
#include <algorithm>
#include <array>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tools/sim/controller/controller.hpp"

namespace truepose::sim {
namespace {

using krl::Literal;
using krl::Parts;
using krl::Value;

constexpr std::size_t kAxesOfE6Axis = 12;

Value axes_deg(const JointVector& q) {
  Parts axes(kAxesOfE6Axis, Value{0.0});
  for (std::size_t i = 0; i < static_cast<std::size_t>(q.size()); ++i)
    axes[i] = q[static_cast<Eigen::Index>(i)] * kDegPerRad;
  return axes;
}

/// External axes, which the arm does not have, have no limits that matter.
double limit_deg(const RobotModel& nominal, int axis, double Joint::*limit) {
  constexpr double kExternal_deg = 0;
  return axis <= nominal.joint_count()
             ? nominal.joints[static_cast<std::size_t>(axis) - 1].*limit * kDegPerRad
             : kExternal_deg;
}

const char* name_of(krl::ProgramState state) {
  switch (state) {
    case krl::ProgramState::Free:
      return "P_FREE";
    case krl::ProgramState::Reset:
      return "P_RESET";
    case krl::ProgramState::Active:
      return "P_ACTIVE";
    case krl::ProgramState::Stopped:
      return "P_STOP";
    case krl::ProgramState::Ended:
      return "P_END";
  }
  return "";
}

}  // namespace

const std::unordered_map<std::string_view, Controller::Reader>& Controller::readers() {
  static const std::unordered_map<std::string_view, Reader> kReaders{
      {"$AXIS_ACT", [](const Controller& c, int) { return axes_deg(c.motion_.position()); }},
      {"$AXIS_ACT_MEAS", [](const Controller& c, int) { return axes_deg(c.actual_); }},
      {"$POS_ACT_MES", [](const Controller& c, int) { return c.pose_at(c.actual_); }},
      {"$POS_ACT", [](const Controller& c, int) { return c.pose_at(c.actual_); }},
      {"$SOFTN_END", [](const Controller& c, int i) { return limit_deg(c.setup_.nominal, i, &Joint::min); }},
      {"$SOFTP_END", [](const Controller& c, int i) { return limit_deg(c.setup_.nominal, i, &Joint::max); }},
      {"$ROBTRAFO", [](const Controller& c, int) { return c.setup_.model; }},
      {"$V_R1MADA", [](const Controller&, int) { return std::string{"KSS 8.6.11 (simulated)"}; }},
      {"$KR_SERIALNO", [](const Controller& c, int) { return c.setup_.serial; }},
      {"$NULLFRAME", [](const Controller&, int) { return Parts(6, Value{0.0}); }},
      {"$WORLD", [](const Controller&, int) { return Parts(6, Value{0.0}); }},
      {"$AXIS_INT", [](const Controller& c, int) { return axes_deg(c.interrupted_at_); }},
      {"$POS_INT", [](const Controller& c, int) { return c.pose_at(c.interrupted_at_); }},
      {"$T1", [](const Controller& c, int) { return c.mode_ == 1; }},
      {"$T2", [](const Controller& c, int) { return c.mode_ == 2; }},
      {"$AUT", [](const Controller& c, int) { return c.mode_ == 3; }},
      {"$EXT", [](const Controller& c, int) { return c.mode_ == 4; }},
      {"$PRO_ACT", [](const Controller& c, int) { return c.robot_->state() == krl::ProgramState::Active; }},
      {"$DRIVES_ON", [](const Controller& c, int) { return c.drives_on_; }},
      {"$PRO_STATE0", [](const Controller& c, int) { return Literal{name_of(c.submit_->state())}; }},
      {"$PRO_STATE", [](const Controller& c, int) { return Literal{name_of(c.robot_->state())}; }},
      {"$PRO_MODE", [](const Controller&, int) { return Literal{"GO"}; }},
      {"$KINCLASS", [](const Controller&, int) { return Literal{"STANDARD"}; }},
      {"$NUM_AX", [](const Controller&, int) { return 6; }},
      {"$EX_AX_NUM", [](const Controller&, int) { return 0; }},
      {"$ROB_TIMER",
       [](const Controller& c, int) { return static_cast<int>(c.time_ / std::chrono::milliseconds{1}); }},
      {"$DATE", [](const Controller& c, int) { return c.date(); }},
      {"$PRO_STATE1", [](const Controller& c, int) { return Literal{name_of(c.robot_->state())}; }},
      {"$MODE_OP", [](const Controller& c, int) { return Literal{c.mode_name()}; }},
      {"$ROB_STOPPED", [](const Controller& c, int) { return c.motion_.is_standing(); }},
      {"$PRO_MOVE", [](const Controller& c, int) { return !c.motion_.is_standing(); }},
      {"$PERI_RDY", [](const Controller& c, int) { return c.drives_on_; }},
      {"$ALARM_STOP", [](const Controller& c, int) { return !c.emergency_stop_; }},
      {"$USER_SAF", [](const Controller& c, int) { return !c.gate_open_; }},
      {"$STOPMESS", [](const Controller& c, int) { return c.stop_message_; }},
      {"$POWER_FAIL", [](const Controller&, int) { return false; }},
  };
  return kReaders;
}

Value Controller::read(const krl::Variable& variable, std::optional<int> index) {
  const std::string_view name = variable.name;
  if (const auto reader = readers().find(name); reader != readers().end())
    return reader->second(*this, index.value_or(0));
  if (name == "$TIMER") return timer_ms(*index);
  if (name == "$TIMER_FLAG") return timer_ms(*index) > 0;
  if (const Value* const set = variables_.find(name, index.value_or(SystemValues::kNoArray))) return *set;
  if (name == "$TIMER_STOP") return true;
  const bool is_monitored = name.starts_with("$TORQ") || name.starts_with("$COLLMON");
  const bool is_analog = name == "$ANIN" || name == "$ANOUT";
  if ((is_monitored || is_analog) && index) return 0.0;
  // Flags, inputs and outputs that nothing has set.
  const bool is_bit = variable.type.kind == krl::Kind::Bool && variable.type.is_array() == index.has_value();
  return is_bit ? Value{false} : Value{};
}

std::expected<void, std::string> Controller::write(std::string_view name, std::optional<int> index,
                                                   const Value& value) {
  if (readers().contains(name) || name == "$IN")
    return std::unexpected(std::string{name} + " cannot be written by a program");
  if (name == "$TIMER" || name == "$TIMER_STOP") {
    const int ms = name == "$TIMER" ? std::get<std::int32_t>(value) : timer_ms(*index);
    timers_[*index] = {.ms = ms, .since = time_};
  }
  if (name == "$OV_PRO") {
    const int percent = std::get<std::int32_t>(value);
    if (percent < 0 || percent > 100) return std::unexpected("$OV_PRO is 0 to 100");
    motion_.set_override(percent / 100.0);
  }
  variables_.at(name, index.value_or(SystemValues::kNoArray)) = value;
  if (name == "$MSG_T") show_message_of_krc2();
  return {};
}

/// The message of KRC2: VALID puts it on the pendant. A dialog is answered by its first key.
void Controller::show_message_of_krc2() {
  enum Field { Valid, Release, Typ, Modul, Key, ParamTyp, Param, DlgFormat, Answer };
  Parts& message = std::get<Parts>(variables_.at("$MSG_T"));
  if (message[Valid] != Value{true}) return;
  message[Valid] = false;
  message[Answer] = 1;
  show({.text = krl::text_of(message[Modul]) + ": " + krl::text_of(message[Key]) + " " +
                krl::text_of(message[Param])});
}

/// A timer stands until $TIMER_STOP is taken away.
int Controller::timer_ms(int number) const {
  const auto timer = timers_.find(number);
  const Timer from = timer == timers_.end() ? Timer{} : timer->second;
  const Value* const stopped = variables_.find("$TIMER_STOP", number);
  const bool runs = stopped != nullptr && *stopped == Value{false};
  return from.ms + (runs ? static_cast<int>((time_ - from.since) / std::chrono::milliseconds{1}) : 0);
}

std::optional<Eigen::Isometry3d> Controller::frame_in(std::string_view variable) const {
  const Value* const found = variables_.find(variable);
  const auto* const parts = found == nullptr ? nullptr : std::get_if<Parts>(found);
  if (parts == nullptr) return std::nullopt;
  const auto at = [&](std::size_t i) { return krl::number_of((*parts)[i]); };
  return pose_from_kuka({at(0), at(1), at(2)}, {at(3), at(4), at(5)});
}

/// There is none while no tool or base is in effect, as after a cancelled program.
Value Controller::pose_at(const JointVector& q) const {
  const auto base = frame_in("$BASE"), tool = frame_in("$TOOL");
  if (!base || !tool) return {};
  const Eigen::Isometry3d X = inverse_of(*base) * forward_kinematics(setup_.nominal, q) * *tool;
  const Eigen::Vector3d p = X.translation(), abc_deg = kuka_abc_deg(X.linear());
  const StatusTurn branch = motion_.inverse().of_joints(q);
  return Parts{p.x(),       p.y(), p.z(), abc_deg.x(), abc_deg.y(), abc_deg.z(), branch.status,
               branch.turn, 0.0,   0.0,   0.0,         0.0,         0.0,         0.0};
}

/// The simulator's clock begins with the year 2026.
Value Controller::date() const {
  using namespace std::chrono;
  const auto ms = duration_cast<milliseconds>(time_);
  const year_month_day day{sys_days{year{2026} / January / 1} + floor<days>(ms)};
  const hh_mm_ss clock{ms % days{1}};
  constexpr int kMsOfCentisecond = 10;
  return Parts{static_cast<int>(clock.subseconds().count() / kMsOfCentisecond),
               static_cast<int>(clock.seconds().count()),
               static_cast<int>(clock.minutes().count()),
               static_cast<int>(clock.hours().count()),
               static_cast<int>(static_cast<unsigned>(day.day())),
               static_cast<int>(static_cast<unsigned>(day.month())),
               static_cast<int>(day.year())};
}

/// ERROR_T without an error.
Value Controller::no_error() {
  constexpr std::size_t kName = 24;
  return Parts{0, 0, 0, 0, std::string(kName, '\0'), std::string(kName, '\0')};
}

std::string Controller::mode_name() const {
  static constexpr std::array kModes{"T1", "T2", "AUT", "EX"};
  return kModes.at(static_cast<std::size_t>(mode_) - 1);
}

void Controller::default_variables() {
  variables_.at("$OV_PRO") = 100;
  variables_.at("$OV_JOG") = 100;
  variables_.at("$ADAP_ACC") = Literal{"STEP1"};  // of KRC4, which takes the load into account
  variables_.at("$ERR") = no_error();
  variables_.at("$IPO_MODE") = Literal{"BASE"};
}

}  // namespace truepose::sim
