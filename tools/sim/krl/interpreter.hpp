#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/krl/evaluator.hpp"
#include "tools/sim/krl/host.hpp"
#include "tools/sim/krl/memory.hpp"

namespace truepose::sim::krl {

/// Simulated time since any moment.
using Time = std::chrono::nanoseconds;

/// As $PRO_STATE tells it.
enum class ProgramState {
  Free,     ///< no program is selected
  Reset,    ///< it stands in its first line
  Active,   ///< it runs
  Stopped,  ///< stopped from outside, by HALT or by a fault
  Ended,    ///< it came to its last line
};

enum class InterpreterKind {
  Robot,
  Submit,  ///< must not move the arm
};

/// Executes one program of the controller, in simulated time and without a thread.
///
/// What is modelled:
///
/// Time. Statements take none, but no more than kInstructionsPerTurn are executed in a turn of 1 ms, so that
/// a loop without a wait lets the others continue.
///
/// Advance run. A motion is handed to the host at once, and the program continues while no more than $ADVANCE
/// motions wait behind the one that is made; with 0 it waits for the end of each. It waits until all motions
/// are made at WAIT, HALT, the end of the program, calls of the host's subprograms and all system variables
/// but those that motions take with them (standard.hpp), unless CONTINUE stands before the statement.
///
/// Interrupts. They are looked at before every statement and at every run(), so also while the program waits
/// or the arm moves. They go by the edge, seen only while switched on. A lower number goes first and breaks
/// into a higher one. DISABLE remembers an edge for ENABLE, OFF forgets it. The arm keeps moving during the
/// interrupt program. BRAKE waits until it stands; it resumes when the interrupt program ends. A motion of an
/// interrupt program needs BRAKE before it; the rest of the motion that BRAKE stopped is then planned again
/// from where the arm stands.
///
/// RESUME. It drops all motions and continues behind the call made in the level that declared the interrupt.
/// It is an error where no such call runs: at that level itself, or once the advance run has left the
/// subprogram.
///
/// Numbers. REAL variables hold 32 bits, expressions are computed with 64. A REAL becomes INT by rounding.
///
/// TRIGGER. It belongs to the next motion. What it sets is set, and what it calls is called, when the host
/// has come to its switching point, at a statement or run(), as an interrupt of its priority; the program
/// ends behind the last of them. RESUME drops those of the motions that it drops.
///
/// Splines. A block is one motion, also of the advance run, and what WITH sets is in effect for its motion or
/// segment alone.
///
/// PULSE. The output is the opposite of its level once the time is over, whatever the program does.
///
/// $CYCFLAG. A cyclical flag is what its expression is at every statement and every run().
///
/// ON_ERROR_PROCEED. An error of the next statement ends that statement, and sets $ERR.NUMBER
/// (Fault::number).
///
/// What is not: IMPORT, BCO run and block selection, interrupts while the program is stopped, CONST_VEL and
/// STOP WHEN PATH in splines.
class Interpreter {
 public:
  static constexpr int kInstructionsPerTurn = 1000;
  static constexpr Time kTurn = std::chrono::milliseconds{1};

  /// @param program, memory, host  outlive the interpreter; memory was made of this program
  Interpreter(const Program& program, Memory& memory, Host& host, InterpreterKind kind);

  /// Selects a program, without parameters. Errors: it is not known, or takes some.
  std::expected<void, std::string> select(std::string_view routine);
  void deselect();
  /// Back to the first line: local data and interrupts are forgotten, module data stays.
  void reset();
  /// Starts, or continues behind stop() or HALT. @return false where nothing is selected, it ended, or a
  /// fault waits for reset().
  bool start();
  /// Stops the program and the arm.
  void stop();

  /// Executes until the program waits. Call it when next_change() says so, and after everything that the
  /// program may wait for: a variable of the host that changed, a motion that ended, the arm that came to a
  /// stand.
  /// @param now  never goes back
  void run(Time now);
  /// When run() is next wanted by time alone.
  std::optional<Time> next_change() const;

  ProgramState state() const { return state_; }
  /// Why the program stopped by itself.
  const std::optional<Fault>& fault() const { return fault_; }
  /// The line that is executed; 0 where no program runs.
  int line() const;

 private:
  enum class WaitFor { Nothing, Condition, Moment, Room, Arrival, Switching, Standstill, External };
  struct Wait {
    WaitFor what = WaitFor::Nothing;
    Time until{0};
    std::size_t most = 0;    // Room: motions that may be unfinished
    std::uint64_t turn = 0;  // Condition, External: the run() that found it unfulfilled
  };
  /// What makes a frame that of an interrupt.
  struct Interruption {
    int priority = 0;
    std::optional<std::size_t> level;  // the frame that declared it, while it is there
    bool may_move = false;             // BRAKE came before
    bool holds = false;                // the arm stands by BRAKE
    bool moves = false;
    std::deque<Motion> parked;              // what BRAKE stopped, where the interrupt program moves itself
    std::vector<SwitchingPoint> switching;  // of the motion that comes next where it was broken into
  };
  struct Frame {
    std::size_t at = 0;
    std::size_t operands = 0;  // of the frames below
    Wait wait = {};
    bool calls_again = false;  // the call of the host is not finished
    int proceeds = 0;          // statements that begin until an error stops the program again
    std::optional<Interruption> interruption = {};
  };
  struct Interrupt {
    int priority = 0;
    std::size_t shape = 0;
    std::optional<std::size_t> level;
    bool is_on = false, is_enabled = true;
    bool was_true = false, is_pending = false;
  };
  struct Trigger {
    std::uint64_t number = 0;  // of the switching point
    std::size_t action = 0;
    int priority = 0;
    bool is_switched = false;
  };
  struct Pulse {
    Place output;
    bool level = false;  // when it ends
    Time ends{0};
  };
  /// What WITH sets.
  struct Setting {
    Place place;
    Value value;
  };

  std::string why_not_loaded(std::string_view routine) const;
  void execute_turn();
  void step();
  void control(const Instruction& instruction);
  bool is_over(const Wait& wait);
  void wait_for(Wait wait) { frames_.back().wait = wait; }
  void stop_by(Fault fault);
  void end_program();

  void enter(std::size_t routine);
  void leave(bool has_value);
  void pop_frame();
  void call_external(const Instruction& instruction);
  std::vector<Value> external_arguments(const External& external, std::size_t count);
  void finish_external(const External& external, std::size_t count, std::vector<Value>& arguments,
                       Value result);

  // motions.cpp
  void move(const MotionShape& shape);
  Motion popped(const MotionShape& shape);
  void pop_target(const MotionShape& shape, Motion& motion);
  void pop_settings(std::size_t count);
  void make_room_in_interrupt();
  void hand_over(Motion motion);
  std::size_t unfinished();
  /// The same, but in an interrupt program only its own: it does not wait for what it broke into.
  std::size_t awaited();
  std::optional<double> number(std::string_view variable, std::optional<int> index, std::string_view field);
  std::optional<FrameValues> frame_values(std::string_view variable);
  Value in_effect(std::size_t variable, std::optional<int> index) const;
  void take_variables(Motion& motion);
  PoseTarget pose_of(const Value& value, const Type& type) const;
  AxisTarget axes_of(const Value& value, const Type& type) const;

  // interrupts.cpp
  void declare_interrupt(std::size_t shape);
  void switch_interrupt(InterruptSwitch to, std::optional<int> priority);
  Interrupt* effective(int priority);
  bool is_true(const Interrupt& interrupt);
  void look_at_interrupts();
  void fire(std::size_t action, Interruption interruption);
  std::optional<std::size_t> interrupt_frame() const;
  void brake(bool with_all_force);
  void resume();
  bool is_braked() const;
  /// Behind an interrupt program. @return false while its own motions are made
  bool end_interruption();

  // switching.cpp
  void pulse();
  void end_pulses();
  void set_cycle(std::size_t cycle, int flag);
  void set_cyclical_flags();
  /// Goes on behind the statement in work. @return false where its error stops the program
  bool proceed_after_error(int number);

  // triggers.cpp
  SwitchingPoint pop_switching_point(const TriggerShape& shape);
  /// @return whether one was carried out
  bool look_at_triggers();

  const Program& program_;
  Host& host_;
  InterpreterKind kind_;
  Evaluator evaluator_;
  ProgramState state_ = ProgramState::Free;
  std::optional<std::size_t> selected_;
  std::optional<Fault> fault_;
  std::vector<Frame> frames_;
  std::vector<Interrupt> interrupts_;
  std::deque<Motion> sent_;  // to the host, and not finished
  std::vector<Trigger> triggers_;
  std::vector<SwitchingPoint> switching_;  // of the motion that comes next
  std::vector<Setting> settings_;          // in effect for the motion in work
  std::vector<Pulse> pulses_;
  std::map<int, std::size_t> cycles_;  // code of cyclical flags, by number
  std::uint64_t motions_ = 0, points_ = 0;
  std::uint64_t turn_ = 0;
  Time now_{0};
  bool is_held_ = false;     // stop() braked the arm
  bool is_hurried_ = false;  // the turn ended before the program waited
  bool has_changed_ = true;  // what interrupts wait for, since they were last looked at, may have
};

}  // namespace truepose::sim::krl
