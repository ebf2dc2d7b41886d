#include "tools/sim/krl/lexer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "tools/sim/krl/fault.hpp"

namespace truepose::sim::krl {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool starts_name(char c) { return is_letter(c) || c == '_' || c == '$'; }
bool continues_name(char c) { return starts_name(c) || is_digit(c); }

char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::array<std::string_view, 4> kLongSymbols = {"==", "<>", "<=", ">="};
constexpr std::string_view kShortSymbols = "()[]{},.:=+-*/<>";

/// One line of KRL.
class LineLexer {
 public:
  LineLexer(const std::string& file, std::string_view line, int number)
      : file_{file}, rest_{line}, number_{number} {}

  std::vector<Token> tokens() {
    for (skip_blanks(); !rest_.empty() && rest_[0] != ';'; skip_blanks()) read_token();
    return std::move(tokens_);
  }

 private:
  [[noreturn]] void fail(std::string what) const { throw Fault{file_, number_, std::move(what)}; }

  void skip_blanks() {
    while (!rest_.empty() && is_blank(rest_[0])) rest_.remove_prefix(1);
  }

  std::string_view take(std::size_t length) {
    const std::string_view taken = rest_.substr(0, length);
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view take_while(bool (*belongs)(char)) {
    return take(static_cast<std::size_t>(std::ranges::find_if_not(rest_, belongs) - rest_.begin()));
  }

  void add(TokenKind kind, std::string_view text) {
    tokens_.push_back({.kind = kind, .text = std::string(text), .line = number_});
  }

  void read_token() {
    const char c = rest_[0];
    const bool begins_fraction = c == '.' && rest_.size() > 1 && is_digit(rest_[1]) && !follows_variable();
    if (starts_name(c)) return add(TokenKind::Name, in_capitals(take_while(continues_name)));
    if (is_digit(c) || begins_fraction) return read_number();
    if (c == '"') return read_text();
    if (c == '\'') return read_coded_number();
    if (c == '#') return read_literal();
    read_symbol();
  }

  bool follows_variable() const {
    return !tokens_.empty() && (tokens_.back().kind == TokenKind::Name || tokens_.back().is("]"));
  }

  void read_literal() {
    take(1);
    const std::string_view name = take_while(continues_name);
    if (name.empty()) fail("# stands without the name of a constant");
    add(TokenKind::Literal, in_capitals(name));
  }

  void read_symbol() {
    for (const std::string_view symbol : kLongSymbols) {
      if (rest_.starts_with(symbol)) return add(TokenKind::Symbol, take(2));
    }
    if (kShortSymbols.find(rest_[0]) == std::string_view::npos) {
      const bool is_printable = rest_[0] > ' ' && rest_[0] <= '~';
      fail(is_printable ? std::string("the character ") + rest_[0] + " does not belong here"
                        : "a character that KRL does not know");
    }
    add(TokenKind::Symbol, take(1));
  }

  void read_text() {
    const std::size_t closing = rest_.find('"', 1);
    if (closing == std::string_view::npos) fail("the text is not closed in its line");
    add(TokenKind::Text, take(closing + 1).substr(1, closing - 1));
  }

  void read_coded_number() {
    const std::size_t closing = rest_.find('\'', 1);
    if (closing == std::string_view::npos || closing < 3)
      fail("a number such as 'H1F' or 'B101' is expected");
    const std::string_view coded = take(closing + 1).substr(1, closing - 1);
    const char base = capital(coded[0]);
    const int radix = base == 'H' ? 16 : base == 'B' ? 2 : base == 'D' ? 10 : 0;
    std::uint32_t number = 0;
    const char* const end = coded.data() + coded.size();
    if (radix == 0 || std::from_chars(coded.data() + 1, end, number, radix).ptr != end)
      fail("a number such as 'H1F' or 'B101' is expected");
    add(TokenKind::Integer, coded);
    tokens_.back().integer = static_cast<std::int32_t>(number);
  }

  void read_number() {
    std::size_t length = 0;
    const auto skip_digits = [&] {
      while (length < rest_.size() && is_digit(rest_[length])) ++length;
    };
    skip_digits();
    bool is_real = false;
    if (length < rest_.size() && rest_[length] == '.') {
      is_real = true;
      ++length;
      skip_digits();
    }
    if (const std::size_t exponent = exponent_length(length); exponent > 0) {
      is_real = true;
      length += exponent;
    }
    const std::string_view digits = take(length);
    const char* const end = digits.data() + digits.size();
    add(is_real ? TokenKind::Real : TokenKind::Integer, digits);
    Token& token = tokens_.back();
    const bool is_good = is_real ? std::from_chars(digits.data(), end, token.real).ec == std::errc{}
                                 : std::from_chars(digits.data(), end, token.integer).ec == std::errc{};
    if (!is_good) fail("the number " + token.text + " is too great");
  }

  std::size_t exponent_length(std::size_t from) const {
    std::size_t at = from;
    if (at >= rest_.size() || capital(rest_[at]) != 'E') return 0;
    ++at;
    if (at < rest_.size() && (rest_[at] == '+' || rest_[at] == '-')) ++at;
    const std::size_t digits = at;
    while (at < rest_.size() && is_digit(rest_[at])) ++at;
    return at > digits ? at - from : 0;
  }

  const std::string& file_;
  std::string_view rest_;
  int number_;
  std::vector<Token> tokens_;
};

}  // namespace

std::string in_capitals(std::string_view name) {
  std::string result(name);
  std::ranges::transform(result, result.begin(), capital);
  return result;
}

std::vector<Statement> cut_into_statements(const std::string& file, std::string_view text) {
  std::vector<Statement> statements;
  bool goes_on = false;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with('&')) continue;
    std::vector<Token> tokens = LineLexer(file, line, number).tokens();
    if (tokens.empty()) continue;
    if (goes_on) {
      std::ranges::move(tokens, std::back_inserter(statements.back().tokens));
    } else {
      statements.push_back({std::move(tokens), number});
    }
    goes_on = statements.back().tokens.back().is(",");
  }
  return statements;
}

}  // namespace truepose::sim::krl
