#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <variant>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using Number = std::variant<std::int32_t, double>;

/// A text of KRL and what C++ makes of it; nothing where a division by zero or an overflow is in it.
struct Drawn {
  std::string text;
  std::optional<Number> value;
};

double as_real(const Number& number) {
  return std::visit([](auto n) { return static_cast<double>(n); }, number);
}

std::int32_t around(std::int64_t n) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(n)); }

std::optional<Number> applied(char symbol, const Number& left, const Number& right) {
  if (symbol == '/' && as_real(right) == 0) return std::nullopt;
  if (std::holds_alternative<std::int32_t>(left) && std::holds_alternative<std::int32_t>(right)) {
    const std::int64_t a = std::get<std::int32_t>(left), b = std::get<std::int32_t>(right);
    return around(symbol == '+' ? a + b : symbol == '-' ? a - b : symbol == '*' ? a * b : a / b);
  }
  const double a = as_real(left), b = as_real(right);
  const double result = symbol == '+' ? a + b : symbol == '-' ? a - b : symbol == '*' ? a * b : a / b;
  return std::isfinite(result) ? std::optional<Number>{result} : std::nullopt;
}

/// Draws expressions with no more brackets than KRL's precedence needs.
class Drawer {
 public:
  explicit Drawer(std::uint32_t seed) : random_{seed} {}

  Drawn sum(int depth) { return chain(depth, "+-", &Drawer::product); }

  /// Of whole numbers alone, with the operators on bits between sums and comparisons.
  Drawn bits(int depth) {
    is_whole_ = true;
    Drawn left = sum(depth);
    const Drawn right = sum(depth), last = sum(depth);
    Drawn result{left.text + " B_OR " + right.text + " B_AND " + last.text, std::nullopt};
    if (left.value && right.value && last.value)
      result.value = Number{std::get<std::int32_t>(*left.value) |
                            (std::get<std::int32_t>(*right.value) & std::get<std::int32_t>(*last.value))};
    return result;
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint32_t>(n)); }

  Drawn chain(int depth, const std::string& symbols, Drawn (Drawer::*part)(int)) {
    Drawn result = (this->*part)(depth);
    for (int more = below(3); more > 0; --more) {
      const char symbol = symbols[static_cast<std::size_t>(below(2))];
      const Drawn right = (this->*part)(depth);
      result.text += std::string(below(2) ? " " : "") + symbol + (below(2) ? " " : "") + right.text;
      if (result.value)
        result.value = right.value ? applied(symbol, *result.value, *right.value) : std::nullopt;
    }
    return result;
  }

  Drawn product(int depth) { return chain(depth, "*/", &Drawer::factor); }

  Drawn factor(int depth) {
    const int kind = below(depth > 0 ? 4 : 2);
    if (kind == 2) {
      const Drawn inside = sum(depth - 1);
      return {"(" + inside.text + ")", inside.value};
    }
    if (kind == 3) {
      Drawn inside = factor(depth - 1);
      if (inside.value) inside.value = applied('-', Number{0}, *inside.value);
      // 0 - 0.0 is 0.0, and -0.0 is equal to it.
      return {"-" + inside.text, inside.value};
    }
    if (kind == 1 && !is_whole_) {
      const int quarters = below(4000);
      std::string text = std::to_string(quarters / 4.0);
      return {text, Number{quarters / 4.0}};
    }
    const std::int32_t whole = below(below(10) == 0 ? 2'000'000'000 : 20);
    return {std::to_string(whole), Number{whole}};
  }

  std::mt19937 random_;
  bool is_whole_ = false;
};

TEST(Arithmetic, OfRandomExpressionsIsThatOfCpp) {
  for (std::uint32_t seed = 1; seed <= 1500; ++seed) {
    Drawer drawer(seed);
    const Drawn drawn = seed % 3 == 0 ? drawer.bits(2) : drawer.sum(3);
    const bool is_whole = drawn.value && std::holds_alternative<std::int32_t>(*drawn.value);
    Bench bench(program_of((is_whole ? "I=" : "R=") + drawn.text, "DECL INT I=0\nDECL REAL R=0"));
    const Interpreter& interpreter = bench.start("P");
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + drawn.text);
    if (!drawn.value || (!is_whole && !std::isfinite(static_cast<float>(as_real(*drawn.value))))) {
      EXPECT_TRUE(interpreter.fault());
      continue;
    }
    ASSERT_FALSE(interpreter.fault()) << interpreter.fault()->text();
    if (is_whole) {
      EXPECT_EQ(bench.integer("I"), std::get<std::int32_t>(*drawn.value));
    } else {
      EXPECT_EQ(bench.real("R"), static_cast<double>(static_cast<float>(as_real(*drawn.value))));
    }
  }
}

TEST(Arithmetic, ComparesAsCppDoes) {
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    Drawer drawer(seed);
    const Drawn left = drawer.sum(2), right = drawer.sum(2);
    if (!left.value || !right.value) continue;
    Bench bench(program_of("A=" + left.text + "<" + right.text + "\nB=" + left.text + ">=" + right.text,
                           "DECL BOOL A\nDECL BOOL B"));
    bench.start("P");
    const bool is_less = as_real(*left.value) < as_real(*right.value);
    EXPECT_EQ(std::get<bool>(bench.variable("A")), is_less) << "seed " << seed << ": " << left.text;
    EXPECT_EQ(std::get<bool>(bench.variable("B")), !is_less) << "seed " << seed << ": " << right.text;
  }
}

}  // namespace
}  // namespace truepose::sim::krl
