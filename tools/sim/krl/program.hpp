#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/type.hpp"

namespace truepose::sim::krl {

/// The comment of an instruction shows the stack of operands: before -> after.
enum class Op : std::uint8_t {
  // Places and values
  Push,         ///< -> constant a
  Global,       ///< -> place of module variable a
  Local,        ///< -> place of local variable a; of what it stands for where it is a parameter by reference
  System,       ///< -> place of system variable a
  Index,        ///< place, INT -> place of its element
  Bits,         ///< place of a BOOL array -> place of the INT made of b elements from a on, from 0
  Field,        ///< place -> place of its component a
  Fetch,        ///< place -> its value
  FetchGlobal,  ///< -> value of module variable a
  FetchLocal,   ///< -> value of local variable a
  FetchSystem,  ///< -> value of system variable a; of its element b where b is not 0
  Store,        ///< place, value ->
  ToReal,       ///< number -> REAL
  ToInt,        ///< number -> INT
  ToCode,       ///< CHAR -> INT
  ToChar,       ///< INT -> CHAR
  Reshape,      ///< structure of type a -> structure of type b, by the names of its components
  Gather,       ///< values -> structure of type a with the components of shape b
  Drop,         ///< value ->
  // Operators
  Negate,
  Not,
  BitNot,
  Add,
  Subtract,
  Multiply,
  Divide,
  Equal,
  Unequal,
  Less,
  LessEqual,
  Greater,
  GreaterEqual,
  And,
  Or,
  Exor,
  BitAnd,
  BitOr,
  BitExor,
  Compose,        ///< structure of type a, structure of type b -> structure of type b
  Absolute,       ///< number -> number
  InversePose,    ///< structure of type a -> the same
  VariableState,  ///< place -> VAR_STATE
  // Control
  Statement,     ///< a new statement begins: here interrupts are looked at
  Jump,          ///< to a
  JumpUnless,    ///< BOOL ->; to a where it is FALSE
  ForGoesOn,     ///< INT -> BOOL; the end stands in local variable a, the step in the next
  Call,          ///< arguments -> result; subprogram a
  CallExternal,  ///< arguments -> result; subprogram a, b arguments
  Return,        ///< ends the subprogram; b: a value is on the stack
  Done,          ///< ends what is evaluated aside: initial values, the condition of an interrupt
  NoResult,      ///< a function came to its end without RETURN
  AdvanceStop,   ///< waits until the arm has come so far
  WaitFor,       ///< BOOL ->; back to a where it is FALSE
  WaitSec,       ///< number ->
  Halt,
  Refuse,   ///< stops the program: what refusals[a] says
  Trigger,  ///< path, delay and, of a call, priority ->; trigger a
  Move,     ///< what motion a takes with it ->
  Pulse,    ///< place of a BOOL, BOOL, number ->
  Cycle,    ///< INT ->; from now on $CYCFLAG of that number is what cycles[a] computes
  Proceed,  ///< an error of the next statement does not stop the program
  Brake,    ///< a: with all force
  Resume,
  DeclareInterrupt,  ///< INT ->; declaration a
  SwitchInterrupt,   ///< INT or, where b is 0, nothing ->; InterruptSwitch a
};

enum class InterruptSwitch { On, Off, Enable, Disable };

struct Instruction {
  Op op = Op::Done;
  std::int32_t a = 0;
  std::int32_t b = 0;
  std::int32_t line = 0;
  std::int32_t file = 0;
};

enum class Direction { In, Out };

struct Parameter {
  std::string name;
  Type type;
  Direction direction = Direction::Out;
};

/// DEF or DEFFCT.
struct Routine {
  std::string name;
  int file = 0;
  int line = 0;
  int module = 0;
  bool is_global = false;
  std::vector<Parameter> parameters;
  Type result;
  std::vector<Value> locals;       ///< the parameters first
  std::vector<Field> local_names;  ///< and their types, in the order of `locals`
  std::size_t entry = 0;
};

/// EXT or EXTFCT: a subprogram that the host carries out, or the interpreter itself.
struct External {
  std::string name;
  std::vector<Parameter> parameters;
  Type result;
  bool is_builtin = false;
  bool passes_advance_run = false;
};

struct Variable {
  std::string name;
  Type type;
  Type element = {};  ///< of a system variable that is an array: of each
  bool is_constant = false;
  bool is_global = false;
  int module = 0;
  bool passes_advance_run = false;
};

enum class MotionKind {
  Ptp,
  Lin,
  Circ,
  PtpRel,
  LinRel,
  Spl,        ///< a segment of a spline block
  Spline,     ///< a block of Spl, Lin and Circ, made as one motion
  PtpSpline,  ///< a block of Ptp
};

/// What stands behind the target of a motion.
enum class Approximation { None, Ptp, Dis, Vel, Ori, Spl };

/// TRIGGER.
struct TriggerShape {
  bool from_start = false;  ///< DISTANCE=0 or ONSTART; else from the end of the motion
  bool is_call = false;     ///< with a priority; else an assignment
  std::size_t action = 0;   ///< ends with Return
};

/// Its operands stand in this order: what its triggers need, the segments, the auxiliary point, the target,
/// the angle, a place and a value for each setting, and the times of TIME_BLOCK.
struct MotionShape {
  MotionKind kind = MotionKind::Ptp;
  Type target;
  Type via;
  bool has_angle = false;    ///< CA
  std::size_t settings = 0;  ///< of WITH
  bool is_in_tool = false;   ///< of a relative motion: #TOOL
  bool ends_part = false;    ///< of a segment: TIME_BLOCK PART behind it
  bool ends_time = false;    ///< of a segment: TIME_BLOCK END behind it
  Approximation approximation = Approximation::None;
  std::vector<TriggerShape> triggers = {};  ///< of a segment
  std::vector<MotionShape> segments = {};   ///< of a block
};

struct InterruptShape {
  std::size_t condition = 0;  ///< ends with Done
  std::size_t call = 0;       ///< begins with the arguments, ends with Return
  bool is_global = false;
};

/// What load() makes of all sources: never changed any more, shared by all interpreters.
struct Program {
  Types types;
  std::vector<std::string> files;
  std::vector<Instruction> code;
  std::vector<Value> constants;
  std::vector<std::vector<int>> shapes;  ///< which components an aggregate sets
  std::vector<MotionShape> motions;
  std::vector<TriggerShape> triggers;  ///< outside of spline blocks
  std::vector<InterruptShape> interrupts;
  std::vector<std::size_t> cycles;  ///< code of cyclical flags; ends with Done
  std::vector<Routine> routines;
  std::vector<External> externals;
  std::vector<Variable> globals;
  std::vector<Variable> systems;
  std::vector<Fault> refusals;     ///< of partial sources: what is not known of them
  std::size_t initial_values = 0;  ///< code that sets the module data

  /// @param name  in capitals. @return the first of that name in any module, one that is global before others
  std::optional<std::size_t> find_routine(std::string_view name) const;
  std::optional<std::size_t> find_system(std::string_view name) const;
};

}  // namespace truepose::sim::krl
