#include "proto/krl/lexer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <utility>

namespace truepose::krl {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::array<std::string_view, 4> kLongSymbols = {"==", "<>", "<=", ">="};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool starts_name(char c) { return is_letter(c) || c == '_' || c == '$'; }
bool continues_name(char c) { return starts_name(c) || is_digit(c); }
char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::size_t behind(std::string_view text, std::size_t from, bool (*belongs)(char)) {
  return static_cast<std::size_t>(
      std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), belongs) - text.begin());
}

/// Length of E-3 at `from`; 0 where there is none.
std::size_t exponent_length(std::string_view text, std::size_t from) {
  if (from >= text.size() || capital(text[from]) != 'E') return 0;
  const bool is_signed = from + 1 < text.size() && (text[from + 1] == '+' || text[from + 1] == '-');
  const std::size_t first = from + (is_signed ? 2 : 1),
                    end = behind(text, std::min(first, text.size()), is_digit);
  return end > first ? end - from : 0;
}

/// The number that a text starts with: 12, 1.5, .5, 2., 1.5E-3.
std::pair<TokenKind, std::size_t> number_in(std::string_view text) {
  const std::size_t whole = behind(text, 0, is_digit);
  const bool has_point = whole < text.size() && text[whole] == '.';
  const std::size_t end = has_point ? behind(text, whole + 1, is_digit) : whole;
  const std::size_t exponent = exponent_length(text, end);
  return {has_point || exponent > 0 ? TokenKind::Real : TokenKind::Integer, end + exponent};
}

/// 'B0101', 'HFF' and 'D10'; blanks within are allowed.
std::optional<double> coded_number(std::string_view quoted) {
  std::string coded;
  std::ranges::copy_if(quoted.substr(1, quoted.size() - 2), std::back_inserter(coded),
                       [](char c) { return c != ' '; });
  const char base = coded.empty() ? ' ' : capital(coded[0]);
  const int radix = base == 'H' ? 16 : base == 'B' ? 2 : base == 'D' ? 10 : 0;
  unsigned value = 0;
  const char* const last = coded.data() + coded.size();
  if (radix == 0) return std::nullopt;
  const auto [end, error] = std::from_chars(coded.data() + 1, last, value, radix);
  return error == std::errc{} && end == last ? std::optional<double>(value) : std::nullopt;
}

class Cutter {
 public:
  explicit Cutter(std::string_view text) : text_{text} {
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
  }

  std::vector<Statement> statements() {
    std::vector<Statement> statements;
    for (bool goes_on = false; at_ < text_.size(); ++line_) {
      tokens_.clear();
      read_line();
      if (tokens_.empty()) continue;
      if (!goes_on) statements.emplace_back();
      std::ranges::copy(tokens_, std::back_inserter(statements.back()));
      goes_on = tokens_.back().is(",");
    }
    return statements;
  }

 private:
  void read_line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::size_t first = behind(text_.substr(0, end), at_, is_blank);
    rest_ = text_.substr(first, end - first);
    at_ = first;
    if (!rest_.starts_with('&')) read_tokens();
    at_ = std::min(end + 1, text_.size());
  }

  void read_tokens() {
    while (!rest_.empty() && rest_[0] != ';') {
      const auto [kind, length] = next();
      tokens_.push_back({kind, rest_.substr(0, length), at_, line_});
      skip(behind(rest_, length, is_blank));
    }
  }

  std::pair<TokenKind, std::size_t> next() const {
    const char c = rest_[0];
    if (starts_name(c)) return {TokenKind::Name, behind(rest_, 1, continues_name)};
    if (c == '#') return {TokenKind::Constant, behind(rest_, 1, continues_name)};
    const bool begins_fraction = c == '.' && rest_.size() > 1 && is_digit(rest_[1]) && !follows_variable();
    if (is_digit(c) || begins_fraction) return number_in(rest_);
    if (c == '"' || c == '\'') return quoted(c);
    const bool is_long = std::ranges::count(kLongSymbols, rest_.substr(0, 2)) > 0;
    return {TokenKind::Symbol, is_long ? 2 : 1};
  }

  std::pair<TokenKind, std::size_t> quoted(char mark) const {
    const std::size_t closing = rest_.find(mark, 1);
    if (closing != std::string_view::npos)
      return {mark == '"' ? TokenKind::Text : TokenKind::Coded, closing + 1};
    if (mark == '"') throw Fault{at_, "a text that is not closed; close it in the same line"};
    return {TokenKind::Symbol, 1};
  }

  bool follows_variable() const {
    return !tokens_.empty() && (tokens_.back().kind == TokenKind::Name || tokens_.back().is("]"));
  }

  void skip(std::size_t length) {
    rest_.remove_prefix(length);
    at_ += length;
  }

  std::string_view text_, rest_;  // rest_: of the line
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<Token> tokens_;  // of the line
};

}  // namespace

bool Token::is(std::string_view word) const {
  const bool has_word = kind == TokenKind::Name || kind == TokenKind::Constant || kind == TokenKind::Symbol;
  return has_word && std::ranges::equal(text, word, {}, capital);
}

bool Token::is_any_of(std::initializer_list<std::string_view> words) const {
  return std::ranges::any_of(words, [&](std::string_view word) { return is(word); });
}

std::string Token::word() const {
  if (kind == TokenKind::Name) return in_capitals(text);
  if (kind == TokenKind::Constant) return in_capitals(text.substr(1));
  const bool is_quoted = kind == TokenKind::Text || kind == TokenKind::Coded;
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

std::optional<double> Token::number() const {
  if (kind == TokenKind::Coded) return coded_number(text);
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  const bool is_number = kind == TokenKind::Integer || kind == TokenKind::Real;
  return is_number && error == std::errc{} && end == last ? std::optional(value) : std::nullopt;
}

std::string in_capitals(std::string_view name) {
  std::string result(name);
  std::ranges::transform(result, result.begin(), capital);
  return result;
}

std::expected<std::vector<Statement>, Fault> cut_into_statements(std::string_view text) {
  try {
    return Cutter(text).statements();
  } catch (const Fault& fault) {
    return std::unexpected(fault);
  }
}

}  // namespace truepose::krl
