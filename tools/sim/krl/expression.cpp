#include "tools/sim/krl/expression.hpp"

#include <array>
#include <span>
#include <utility>

namespace truepose::sim::krl {
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
    Expression result{.kind = ExpressionKind::Name, .token = reader_.peek()};
    reader_.take_name("a variable");
    while (true) {
      if (reader_.next_is("[")) {
        result = element(std::move(result));
      } else if (reader_.next_is(".")) {
        reader_.take();
        Expression component{.kind = ExpressionKind::Component, .token = reader_.peek()};
        reader_.take_name("a component");
        component.parts.push_back(std::move(result));
        result = std::move(component);
      } else {
        return result;
      }
      if (++links_ > kDeepest) reader_.fail("the variable has too many parts");
    }
  }

  Expression call(Token name) {
    Expression result{.kind = ExpressionKind::Call, .token = std::move(name)};
    reader_.expect("(");
    while (!reader_.next_is(")")) {
      const bool is_first = result.parts.empty();
      if (!is_first) reader_.expect(",");
      const bool is_omitted = reader_.next_is(",") || (!is_first && reader_.next_is(")"));
      result.parts.push_back(is_omitted ? Expression{.kind = ExpressionKind::Omitted} : expression());
    }
    reader_.take();
    return result;
  }

 private:
  void deeper() {
    if (++depth_ > kDeepest) reader_.fail("the expression is nested too deeply");
  }

  Expression binary(std::size_t rank) {
    if (rank == kRanks.size()) return unary();
    Expression left = binary(rank + 1);
    int operators = 0;
    while (is_of_rank(rank)) {
      // A long sum is a deep tree to the left.
      if (++operators > kDeepest) reader_.fail("the expression has too many operators");
      Expression both{.kind = ExpressionKind::Binary, .token = reader_.take()};
      both.parts.push_back(std::move(left));
      both.parts.push_back(binary(rank + 1));
      left = std::move(both);
    }
    return left;
  }

  bool is_of_rank(std::size_t rank) const {
    for (const std::string_view symbol : kRanks[rank]) {
      if (reader_.next_is(symbol)) return true;
    }
    return false;
  }

  Expression unary() {
    for (const std::string_view symbol : {"-", "+", "NOT", "B_NOT"}) {
      if (!reader_.next_is(symbol)) continue;
      deeper();
      Expression result{.kind = ExpressionKind::Unary, .token = reader_.take()};
      result.parts.push_back(unary());
      --depth_;
      return result;
    }
    return operand();
  }

  Expression operand() {
    const Token& next = reader_.peek();
    if (reader_.next_is("{")) return aggregate();
    if (reader_.take_if("(")) {
      Expression inside = expression();
      reader_.expect(")");
      return inside;
    }
    if (next.kind == TokenKind::Literal) return {.kind = ExpressionKind::Literal, .token = reader_.take()};
    if (next.kind == TokenKind::Name && !next.is("TRUE") && !next.is("FALSE")) {
      return reader_.peek(1).is("(") ? call(reader_.take()) : variable();
    }
    if (next.kind == TokenKind::Symbol)
      reader_.fail("a value is expected" + (reader_.at_end() ? "" : " before " + next.text));
    return {.kind = ExpressionKind::Constant, .token = reader_.take()};
  }

  Expression element(Expression array) {
    Expression result{.kind = ExpressionKind::Element, .token = reader_.take()};
    result.parts.push_back(std::move(array));
    // NAME[] and NAME[,]
    std::size_t commas = 0;
    while (reader_.peek(commas).is(",")) ++commas;
    if (reader_.peek(commas).is("]")) {
      for (std::size_t i = 0; i <= commas; ++i) reader_.take();
      result.kind = ExpressionKind::Whole;
      return result;
    }
    do {
      // NAME[1,] is a row of an array of texts.
      if (reader_.next_is("]") && result.parts.size() > 1) return whole(std::move(result));
      result.parts.push_back(expression());
    } while (reader_.take_if(","));
    reader_.expect("]");
    return result;
  }

  Expression whole(Expression row) {
    Expression result{.kind = ExpressionKind::Whole, .token = reader_.take()};
    result.parts.push_back(std::move(row));
    return result;
  }

  Expression aggregate() {
    deeper();
    Expression result{.kind = ExpressionKind::Aggregate, .token = reader_.take()};
    result.token.text.clear();
    if (reader_.peek(1).is(":")) {
      result.token.text = reader_.take_name("a structure");
      reader_.take();
    }
    do {
      result.names.push_back(reader_.take_name("a component"));
      if (reader_.take_if("[")) reader_.expect("]");
      result.parts.push_back(expression());
    } while (reader_.take_if(","));
    reader_.expect("}");
    --depth_;
    return result;
  }

  TokenReader& reader_;
  int depth_ = 0;
  int links_ = 0;
};

}  // namespace

bool is_variable(const Expression& expression) {
  switch (expression.kind) {
    case ExpressionKind::Name:
    case ExpressionKind::Element:
    case ExpressionKind::Whole:
    case ExpressionKind::Component:
      return true;
    default:
      return false;
  }
}

Expression read_expression(TokenReader& reader) { return ExpressionReader(reader).expression(); }

Expression read_variable(TokenReader& reader) { return ExpressionReader(reader).variable(); }

Expression read_call(TokenReader& reader, Token name) {
  return ExpressionReader(reader).call(std::move(name));
}

}  // namespace truepose::sim::krl
