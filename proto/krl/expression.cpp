#include "proto/krl/expression.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace truepose::krl {
namespace {

/// A text of thousands of brackets must not use up the stack.
constexpr int kDeepest = 60;

constexpr std::array<std::string_view, 6> kComparisons = {"==", "<>", "<=", ">=", "<", ">"};
constexpr std::array<std::string_view, 2> kOr = {"OR", "B_OR"};
constexpr std::array<std::string_view, 2> kExor = {"EXOR", "B_EXOR"};
constexpr std::array<std::string_view, 2> kAnd = {"AND", "B_AND"};
constexpr std::array<std::string_view, 2> kSums = {"+", "-"};
constexpr std::array<std::string_view, 2> kProducts = {"*", "/"};
constexpr std::array<std::string_view, 1> kGeometric = {":"};

/// From the weakest to the strongest.
constexpr std::array<std::span<const std::string_view>, 7> kRanks = {kComparisons, kOr,       kExor,     kAnd,
                                                                     kSums,        kProducts, kGeometric};
constexpr int kNoRank = -1;

class ExpressionReader {
 public:
  explicit ExpressionReader(TokenReader& reader) : reader_{reader} {}

  Expression expression() {
    deeper();
    Expression result = binary(0);
    --depth_;
    return result;
  }

  Expression variable() {
    Expression result = begun(ExpressionKind::Name);
    result.name = reader_.take_name("a variable");
    result.end = reader_.end();
    while (reader_.next_is("[") || reader_.next_is(".")) {
      result = reader_.take_if(".") ? component(std::move(result)) : element(std::move(result));
      if (++links_ > kDeepest) reader_.fail("the variable has too many parts");
    }
    return result;
  }

  Expression call() {
    Expression result = begun(ExpressionKind::Call);
    result.name = reader_.take_name("a subprogram");
    reader_.expect("(");
    while (!reader_.next_is(")")) {
      const bool is_first = result.parts.empty();
      if (!is_first) reader_.expect(",");
      const bool is_omitted = reader_.next_is(",") || (!is_first && reader_.next_is(")"));
      result.parts.push_back(is_omitted ? begun(ExpressionKind::Omitted) : expression());
    }
    take_last(result);
    return result;
  }

 private:
  void deeper() {
    if (++depth_ > kDeepest) reader_.fail("the expression is nested too deeply");
  }

  Expression begun(ExpressionKind kind) const { return {.kind = kind, .token = reader_.peek()}; }

  void take_last(Expression& expression) {
    reader_.take();
    expression.end = reader_.end();
  }

  Expression whole(Expression array) {
    Expression result = around(ExpressionKind::Whole, std::move(array));
    take_last(result);
    return result;
  }

  /// What begins with another expression.
  static Expression around(ExpressionKind kind, Expression first) {
    Expression result{.kind = kind, .token = first.token};
    result.parts.push_back(std::move(first));
    return result;
  }

  /// @param weakest  rank that its operators have at least
  Expression binary(int weakest) {
    Expression left = unary();
    int before = kNoRank, operators = 0;
    for (int rank = next_rank(); rank >= weakest; rank = next_rank()) {
      // A long sum is a deep tree to the left.
      operators = rank == before ? operators + 1 : 1;
      if (operators > kDeepest) reader_.fail("the expression has too many operators");
      left = around(ExpressionKind::Binary, std::move(left));
      left.name = reader_.take().word();
      left.parts.push_back(binary(rank + 1));
      left.end = left.parts.back().end;
      before = rank;
    }
    return left;
  }

  int next_rank() const {
    const Token& next = reader_.peek();
    const auto found = std::ranges::find_if(kRanks, [&](std::span<const std::string_view> operators) {
      return std::ranges::any_of(operators, [&](std::string_view its) { return next.is(its); });
    });
    return found == kRanks.end() ? kNoRank : static_cast<int>(found - kRanks.begin());
  }

  Expression unary() {
    if (!reader_.peek().is_any_of({"-", "+", "NOT", "B_NOT"})) return operand();
    deeper();
    Expression result = begun(ExpressionKind::Unary);
    result.name = reader_.take().word();
    result.parts.push_back(unary());
    result.end = result.parts[0].end;
    --depth_;
    return result;
  }

  Expression operand() {
    const Token& next = reader_.peek();
    if (next.is("{")) return aggregate();
    if (reader_.take_if("(")) {
      Expression inside = expression();
      reader_.expect(")");
      return inside;
    }
    if (next.kind == TokenKind::Name && !next.is("TRUE") && !next.is("FALSE"))
      return reader_.peek(1).is("(") ? call() : variable();
    if (next.kind == TokenKind::Symbol)
      reader_.fail("a value is expected" + (reader_.at_end() ? "" : " before " + next.word()));
    const bool is_literal = next.kind == TokenKind::Constant;
    Expression result = begun(is_literal ? ExpressionKind::Literal : ExpressionKind::Constant);
    result.name = next.word();
    take_last(result);
    return result;
  }

  Expression component(Expression structure) {
    Expression result = around(ExpressionKind::Component, std::move(structure));
    result.name = reader_.take_name("a component");
    result.end = reader_.end();
    return result;
  }

  Expression element(Expression array) {
    reader_.take();
    // NAME[] and NAME[,]
    std::size_t commas = 0;
    while (reader_.peek(commas).is(",")) ++commas;
    if (reader_.peek(commas).is("]")) {
      for (; commas > 0; --commas) reader_.take();
      return whole(std::move(array));
    }
    Expression result = around(ExpressionKind::Element, std::move(array));
    do {
      // NAME[1,] is a row of an array of texts.
      if (reader_.next_is("]") && result.parts.size() > 1) return whole(std::move(result));
      result.parts.push_back(expression());
    } while (reader_.take_if(","));
    reader_.expect("]");
    result.end = reader_.end();
    return result;
  }

  Expression aggregate() {
    deeper();
    Expression result = begun(ExpressionKind::Aggregate);
    reader_.take();
    if (reader_.peek(1).is(":")) {
      result.name = reader_.take_name("a structure");
      reader_.take();
    }
    do {
      result.names.push_back(reader_.peek());
      reader_.take_name("a component");
      if (reader_.take_if("[")) reader_.expect("]");
      result.parts.push_back(expression());
    } while (reader_.take_if(","));
    reader_.expect("}");
    result.end = reader_.end();
    --depth_;
    return result;
  }

  TokenReader& reader_;
  int depth_ = 0;
  int links_ = 0;
};

}  // namespace

bool Expression::is_variable() const {
  switch (kind) {
    case ExpressionKind::Name:
    case ExpressionKind::Element:
    case ExpressionKind::Whole:
    case ExpressionKind::Component:
      return true;
    default:
      return false;
  }
}

const Expression& Expression::root() const { return kind == ExpressionKind::Name ? *this : parts[0].root(); }

const Expression* Expression::find(std::string_view component) const {
  const auto found = std::ranges::find_if(names, [&](const Token& its) { return its.is(component); });
  return found == names.end() ? nullptr : &parts[static_cast<std::size_t>(found - names.begin())];
}

Expression read_expression(TokenReader& reader) { return ExpressionReader(reader).expression(); }

Expression read_variable(TokenReader& reader) { return ExpressionReader(reader).variable(); }

Expression read_call(TokenReader& reader) { return ExpressionReader(reader).call(); }

}  // namespace truepose::krl
