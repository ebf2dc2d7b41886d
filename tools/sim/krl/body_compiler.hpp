#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tools/sim/krl/expression_compiler.hpp"

namespace truepose::sim::krl {

/// A subprogram whose head and declarations are known and whose statements wait to be compiled.
struct Body {
  std::size_t routine = 0;
  std::vector<Field> locals;  ///< the parameters first
  std::span<const Statement> statements;
  Statement end;  ///< END or ENDFCT
  const ModuleFile* file = nullptr;
  bool is_submit = false;
};

/// Finds the subprograms of a .src or .sub. Throws Fault.
/// @param file  outlives the bodies
std::vector<Body> scan_routines(const ModuleFile& file, Symbols& symbols);

/// Writes the code of one subprogram. Throws Fault.
class BodyCompiler {
 public:
  BodyCompiler(const Body& body, Symbols& symbols);
  void compile();

 private:
  void compile_statements();
  bool at_end() const { return at_ == body_.statements.size(); }
  bool next_begins_with(std::string_view word) const;
  /// Compiles until a statement begins with one of the words. @return the word
  std::string block(std::initializer_list<std::string_view> ends, const Statement& opened);
  void statement();
  void dispatch(TokenReader& reader);
  /// Compiles a part of a statement. Of a partial file, what is not known becomes Op::Refuse.
  void attempt(const std::function<void()>& part);
  /// @param leaves_it  goes behind a part that is not known; false where it cannot
  void attempt(const std::function<void()>& part, const std::function<bool()>& leaves_it);
  /// Reads `word` and what follows it alone in its line.
  void close(std::string_view word);

  // control_compiler.cpp
  void compile_if(TokenReader& reader);
  void compile_switch(TokenReader& reader);
  void compile_case(std::size_t subject, const Type& type, std::vector<std::size_t>& exits);
  void compile_for(TokenReader& reader);
  void for_range(TokenReader& reader, const Expression& counter, std::size_t last, std::size_t step);
  void compile_while(TokenReader& reader);
  void compile_repeat(TokenReader& reader);
  void compile_loop(TokenReader& reader);
  void compile_exit(TokenReader& reader);
  void compile_goto(TokenReader& reader);
  void compile_label(TokenReader& reader);
  void compile_return(TokenReader& reader);
  void compile_plain(TokenReader& reader);
  void compile_continue(TokenReader& reader);
  void compile_assignment(TokenReader& reader);
  void condition(TokenReader& reader, const std::string& what);
  void loop(std::string_view end, const std::function<void()>& lead_back);
  void land_gotos();

  // motion_compiler.cpp
  void compile_motion(TokenReader& reader);
  /// Reads a motion of the kind that its first word says, up to its approximation.
  MotionShape motion_shape(TokenReader& reader);
  void compile_targets(const truepose::krl::Motion& motion, MotionShape& shape);
  Approximation read_approximation(TokenReader& reader, bool is_spline);
  void compile_wait(TokenReader& reader);
  void compile_interrupt(TokenReader& reader);
  void declare_interrupt(TokenReader& reader, bool is_global);
  void compile_brake(TokenReader& reader);
  /// A call outside the program's sequence: without its local data.
  void call_out_of_sequence(TokenReader& reader);

  // spline_compiler.cpp
  void compile_spline(TokenReader& reader);
  void compile_block(TokenReader& reader);
  std::vector<MotionShape> segments(MotionKind block, const Statement& opened);
  void emit_settings(const std::vector<Assignment>& settings);

  void read_time(TokenReader& reader, std::vector<MotionShape>& segments);

  // switching_compiler.cpp
  void compile_pulse(TokenReader& reader);
  void read_pulse(TokenReader& reader);
  /// $CYCFLAG[1]=..
  void compile_cyclical(TokenReader& reader);

  // trigger_compiler.cpp
  void compile_trigger(TokenReader& reader);
  TriggerShape read_trigger(TokenReader& reader, bool in_spline);
  void read_switching_point(TokenReader& reader, bool in_spline, TriggerShape& trigger);
  /// An assignment outside the program's sequence.
  void set_out_of_sequence(TokenReader& reader);

  using Compile = void (BodyCompiler::*)(TokenReader&);
  static const std::map<std::string_view, Compile>& statements();
  static const std::map<std::string_view, MotionKind>& motions();

  const Body& body_;
  Symbols& symbols_;
  Scope scope_;
  ExpressionCompiler expressions_;
  std::size_t at_ = 0;
  bool continued_ = false;
  std::vector<std::vector<std::size_t>> exits_;  ///< of each loop around: jumps behind it
  std::vector<int> blocks_;  ///< the branches and loops around, each with a number of its own
  int block_count_ = 0;
  struct Label {
    std::size_t at;
    std::vector<int> blocks;
  };
  std::map<std::string, Label> labels_;
  struct Goto {
    std::size_t jump;
    std::string label;
    std::vector<int> blocks;
    int line;
  };
  std::vector<Goto> gotos_;
};

}  // namespace truepose::sim::krl
