#include "tools/sim/krl/operations.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "tools/sim/krl/frames.hpp"

namespace truepose::sim::krl {
namespace {

[[noreturn]] void refuse(std::string what) { throw Fault{.what = std::move(what)}; }

/// INT has 32 bits and goes round, as the controller's processor does.
std::int32_t wrapped(std::int64_t number) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(number));
}

double checked(double number) {
  if (!std::isfinite(number)) refuse("the result is no number");
  return number;
}

/// Of INT as 64 bits, or REAL.
template <typename Number>
Number arithmetic(Op op, Number left, Number right) {
  switch (op) {
    case Op::Add:
      return left + right;
    case Op::Subtract:
      return left - right;
    case Op::Multiply:
      return left * right;
    default:
      if (right == 0) refuse("a division by zero");
      return left / right;
  }
}

Value result(Op op, const Value& left, const Value& right) {
  const auto *whole_left = std::get_if<std::int32_t>(&left), *whole_right = std::get_if<std::int32_t>(&right);
  if (whole_left && whole_right)
    return wrapped(arithmetic(op, std::int64_t{*whole_left}, std::int64_t{*whole_right}));
  return checked(arithmetic(op, number_of(left), number_of(right)));
}

bool is_number(const Value& value) {
  return std::holds_alternative<std::int32_t>(value) || std::holds_alternative<double>(value);
}

template <typename T>
bool compares(Op op, const T& left, const T& right) {
  switch (op) {
    case Op::Equal:
      return left == right;
    case Op::Unequal:
      return left != right;
    case Op::Less:
      return left < right;
    case Op::LessEqual:
      return left <= right;
    case Op::Greater:
      return left > right;
    default:
      return left >= right;
  }
}

/// Of a CHAR: the controller's characters are Latin-1.
std::int32_t code_of(const Value& value) { return static_cast<unsigned char>(std::get<char>(value)); }

/// A number, or the code of a character.
double ordinal_of(const Value& value) {
  return std::holds_alternative<char>(value) ? code_of(value) : number_of(value);
}

char to_char(std::int32_t code) {
  constexpr std::int32_t kLast = 255;
  if (code < 0 || code > kLast) refuse("the number is no character (0 to 255)");
  return static_cast<char>(static_cast<unsigned char>(code));
}

bool comparison_holds(Op op, const Value& left, const Value& right) {
  if (is_number(left) || std::holds_alternative<char>(left))
    return compares(op, ordinal_of(left), ordinal_of(right));
  if (const auto* truth = std::get_if<bool>(&left)) return compares(op, *truth, std::get<bool>(right));
  return compares(op, std::get<Literal>(left).name, std::get<Literal>(right).name);
}

std::int32_t to_int(double number) {
  const double rounded = std::round(number);
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  if (!(rounded >= -kMost - 1 && rounded <= kMost)) refuse("the number is too great for INT");
  return static_cast<std::int32_t>(rounded);
}

/// @return false where it takes two values
bool operate_on_one(const Instruction& instruction, const Program& program, Evaluator& evaluator) {
  switch (instruction.op) {
    case Op::ToReal:
      evaluator.push(to_real(number_of(evaluator.pop())));
      return true;
    case Op::ToInt:
      evaluator.push(to_int(number_of(evaluator.pop())));
      return true;
    case Op::ToCode:
      evaluator.push(code_of(evaluator.pop()));
      return true;
    case Op::ToChar:
      evaluator.push(to_char(evaluator.pop_int()));
      return true;
    case Op::Negate: {
      const Value value = evaluator.pop();
      const auto* whole = std::get_if<std::int32_t>(&value);
      evaluator.push(whole ? Value{wrapped(-std::int64_t{*whole})} : Value{-std::get<double>(value)});
      return true;
    }
    case Op::Absolute: {
      const Value value = evaluator.pop();
      const auto* whole = std::get_if<std::int32_t>(&value);
      evaluator.push(whole ? Value{wrapped(std::abs(std::int64_t{*whole}))}
                           : Value{std::abs(std::get<double>(value))});
      return true;
    }
    case Op::Not:
      evaluator.push(!evaluator.pop_bool());
      return true;
    case Op::BitNot:
      evaluator.push(~evaluator.pop_int());
      return true;
    case Op::Reshape:
      evaluator.push(reshaped(evaluator.pop(), {Kind::Structure, instruction.a},
                              {Kind::Structure, instruction.b}, program.types));
      return true;
    case Op::InversePose:
      evaluator.push(inverse_of(evaluator.pop(), {Kind::Structure, instruction.a}, program.types));
      return true;
    default:
      return false;
  }
}

}  // namespace

double to_real(double number) { return checked(static_cast<double>(static_cast<float>(number))); }

void operate(const Instruction& instruction, const Program& program, Evaluator& evaluator) {
  if (operate_on_one(instruction, program, evaluator)) return;
  const Op op = instruction.op;
  const Value right = evaluator.pop(), left = evaluator.pop();
  switch (op) {
    case Op::Add:
    case Op::Subtract:
    case Op::Multiply:
    case Op::Divide:
      evaluator.push(result(op, left, right));
      break;
    case Op::And:
      evaluator.push(std::get<bool>(left) && std::get<bool>(right));
      break;
    case Op::Or:
      evaluator.push(std::get<bool>(left) || std::get<bool>(right));
      break;
    case Op::Exor:
      evaluator.push(std::get<bool>(left) != std::get<bool>(right));
      break;
    case Op::BitAnd:
      evaluator.push(std::get<std::int32_t>(left) & std::get<std::int32_t>(right));
      break;
    case Op::BitOr:
      evaluator.push(std::get<std::int32_t>(left) | std::get<std::int32_t>(right));
      break;
    case Op::BitExor:
      evaluator.push(std::get<std::int32_t>(left) ^ std::get<std::int32_t>(right));
      break;
    case Op::Compose:
      evaluator.push(composed(left, {Kind::Structure, instruction.a}, right, {Kind::Structure, instruction.b},
                              program.types));
      break;
    default:
      evaluator.push(comparison_holds(op, left, right));
      break;
  }
}

}  // namespace truepose::sim::krl
