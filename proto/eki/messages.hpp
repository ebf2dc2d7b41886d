#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace truepose::eki {

/// Version of these documents; Hello carries the controller's.
inline constexpr int kProtocolVersion = 1;

using Axes = std::array<double, 6>;

enum class CommandType {
  Ptp = 1,       ///< move the axes to `axes_rad` and settle
  StartRsi = 3,  ///< run the program that opens RSI; Moving = RSI is on, InPosition = it has ended
  NoOp = 9,      ///< only acknowledge
};

/// PC to controller on CellLink: <Cmd Id Type Vel Acc Settle><Ax A1..A6></Ax></Cmd>.
///
/// Every command is answered by Acks with its id. A repeated id is not carried out again: its last Ack is
/// repeated.
struct Command {
  std::int32_t id = 0;
  CommandType type = CommandType::NoOp;
  int velocity_percent = 20;  ///< of the axes' greatest speed
  int acceleration_percent = 50;
  int settle_ms = 500;
  Axes axes_rad{};

  bool operator==(const Command&) const = default;
};

enum class ControlOp {
  SetOverride = 1,  ///< value = $OV_PRO in percent; the controller caps it
  Stop = 2,         ///< brake, leave the running command (its Ack is Aborted), refuse further ones
  ReleaseStop = 3,
  Drives = 4,  ///< value 1 on, 0 off
  AskState = 5,
};

/// PC to controller on CellState: <Ctl Id Op Val></Ctl>. Every control is answered by one State with its id.
struct Control {
  std::int32_t id = 0;
  ControlOp op = ControlOp::AskState;
  int value = 0;

  bool operator==(const Control&) const = default;
};

enum class AckState { Accepted = 1, Moving = 2, InPosition = 3, Rejected = 4, Aborted = 5 };

/// Why a command was rejected or aborted.
enum class AckError {
  None = 0,
  OutOfRange = 1,  ///< a target outside $SOFTN_END..$SOFTP_END; nothing moved
  UnknownType = 2,
  Stopped = 3,        ///< a stop is in effect: release it first
  NotInPosition = 4,  ///< the axes did not reach the target within tolerance
  LinkLost = 5,       ///< the connection broke during the motion
  Rsi = 6,            ///< RSI could not be opened
};

/// Controller to PC on CellLink: <Robot><Ack Id State Err><Ax A1..A6></Ax></Ack></Robot>. The axes are the
/// actual ones.
struct Ack {
  std::int32_t id = 0;
  AckState state = AckState::Accepted;
  int error = 0;  ///< an AckError, or the controller's own message number
  std::optional<Axes> axes_rad;

  bool operator==(const Ack&) const = default;
};

/// Controller to PC on CellLink, once after every connection: <Robot><Hello ../></Robot>, who it is.
struct Hello {
  int version = kProtocolVersion;
  std::string model;            ///< $ROBTRAFO or $MODEL_NAME
  std::string serial;           ///< $KR_SERIALNO
  std::optional<int> tool = 0;  ///< $ACT_TOOL
  std::optional<int> base = 0;  ///< $ACT_BASE
  std::string kss_version;      ///< $V_R1MADA or the KSS version

  bool operator==(const Hello&) const = default;
};

enum class OperatingMode { T1 = 1, T2 = 2, Aut = 3, Ext = 4 };
enum class ProgramState { Free = 1, Reset = 2, Active = 3, Stopped = 4, Ended = 5 };

/// "T1", "T2", "AUT" or "EXT".
std::string_view name(OperatingMode mode);
/// "free", "reset", "active", "stopped" or "ended".
std::string_view name(ProgramState state);

/// Controller to PC on CellState: <Robot><State Seq Id ModeOp OvPro ProState PeriRdy AlarmStop UserSaf
/// StopMess ProMove InPos Serial><Ax/><Pos/><Base No/><Tool No/><ToolFrame/><BaseFrame/><Load
/// M/></State></Robot>. Flags are 0 or 1 and carry
/// KUKA's variables unchanged, so 1 is the healthy value of PeriRdy, AlarmStop and UserSaf.
struct State {
  std::int32_t sequence = 0;  ///< counts the states sent
  std::int32_t id = 0;        ///< of the Control that it answers
  OperatingMode mode = OperatingMode::T1;
  int override_percent = 100;
  ProgramState program = ProgramState::Free;  ///< of the robot interpreter
  bool drives_ready = false;                  ///< $PERI_RDY
  bool no_emergency_stop = false;             ///< $ALARM_STOP: TRUE = none is pressed
  bool gate_closed = false;                   ///< $USER_SAF: TRUE = operator safety closed
  bool stop_message = false;                  ///< $STOPMESS; a stop by ControlOp::Stop does not set it
  bool moving = false;                        ///< $PRO_MOVE
  bool in_position = false;                   ///< no axis moves
  std::optional<int> serial;                  ///< $KR_SERIALNO; none from a program that does not send it
  Axes axes_rad{};                            ///< $AXIS_ACT_MEAS
  std::array<double, 6> pose{};               ///< $POS_ACT: X Y Z in mm, A B C in deg
  std::optional<int> base = 0;                ///< $ACT_BASE; a state may come without
  std::optional<int> tool = 0;                ///< $ACT_TOOL; likewise
  std::optional<std::array<double, 6>> tool_frame;  ///< $TOOL: X Y Z in mm, A B C in deg; none without one
  std::optional<std::array<double, 6>> base_frame;  ///< $BASE; likewise
  std::optional<double> load_kg;                    ///< $LOAD.M; none where the controller has none

  bool operator==(const State&) const = default;
};

using ToController = std::variant<Command, Control>;
using FromController = std::variant<Hello, Ack, State>;

/// One document with open and close pairs (the controller's reader stumbles over <Ax/>), no white space
/// between.
std::string encode(const ToController& message);
std::string encode(const FromController& message);

/// What one complete document says. Elements and attributes in any order, unknown ones skipped. A number may
/// have a plus sign, a whole one decimals of zero, a flag may be TRUE or FALSE, and an attribute without a
/// value is as one that is not there. Error: one sentence that names the document and the field.
std::expected<ToController, std::string> decode_to_controller(std::string_view document);

/// The same of the controller: the messages below <Robot> in their order. That is one, but from EKI 6.1 every
/// configured tag comes with every message: one whose values are all empty says nothing. Hello, Ack and State
/// are read as roots too. Texts are device texts.
std::expected<std::vector<FromController>, std::string> decode_from_controller(std::string_view document);

}  // namespace truepose::eki
