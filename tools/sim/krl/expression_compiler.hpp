#pragma once

#include <string>

#include "tools/sim/krl/scope.hpp"
#include "tools/sim/krl/statement_reader.hpp"

namespace truepose::sim::krl {

/// Writes the code of expressions and checks their types. Throws Fault: an unknown name, a type that does not
/// fit, a wrong number of parameters.
class ExpressionCompiler {
 public:
  explicit ExpressionCompiler(Scope& scope) : scope_{scope} {}

  /// Code that leaves the value on the stack. @return its type
  Type value(const Expression& expression);
  /// The same, made to fit a type. @param what  for the message: "the variable X"
  void value_as(const Expression& expression, const Type& type, const std::string& what);
  /// Code that leaves the place of a variable on the stack.
  Type place(const Expression& expression);
  /// A call that stands alone: its result is dropped.
  void call_statement(const Expression& call);
  void assign(const Expression& target, const Expression& source);
  /// The same in a data list, which gives constants their values too.
  void initialise(const Expression& target, const Expression& source);
  /// The target of a motion: an aggregate without its type's name is one of axes where it names axes.
  Type target(const Expression& expression);

 private:
  Type constant(const Token& token);
  /// An operand of the geometric operator: an aggregate without its type's name is a FRAME, or with S or T a
  /// POS.
  Type frame(const Expression& expression);
  Type variable_value(const Expression& expression);
  /// As place(); an array as a whole is NAME[].
  Type whole_place(const Expression& expression);
  Type name(const Expression& expression);
  Type element(const Expression& expression);
  Type component(const Expression& expression);
  Type unary(const Expression& expression);
  Type binary(const Expression& expression);
  Type comparison(const Expression& expression);
  void compared(const Expression& left, const Expression& right, bool is_equality);
  Type aggregate(const Expression& expression, const Type& type);
  Type call(const Expression& call);
  Type call_routine(const Expression& call, std::size_t index);
  Type call_external(const Expression& call, std::size_t index);
  [[noreturn]] void fail_aside(const Expression& call);
  void arguments(const Expression& call, const std::vector<Parameter>& parameters);
  void omitted(const Parameter& parameter);
  void argument(const Expression& argument, const Parameter& parameter, const std::string& what);
  void out_argument(const Expression& argument, const Type& type, const std::string& what);
  Type absolute(const Expression& call);
  Type inverse_pose(const Expression& call);
  Type variable_state(const Expression& call);
  Type string_write(const Expression& call);
  Type string_read(const Expression& call);
  std::size_t format_arguments(const Expression& call);
  void count_arguments(const Expression& call, std::size_t expected);
  void convert(const Type& from, const Type& to, const std::string& what);
  bool is_frame(const Type& type) const;
  bool is_axes(const Type& type) const;
  std::string type_name(const Type& type) const { return scope_.types().name(type); }

  Scope& scope_;
};

}  // namespace truepose::sim::krl
