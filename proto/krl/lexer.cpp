#include "proto/krl/lexer.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

namespace truepose::krl {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool starts_name(char c) { return is_letter(c) || c == '_' || c == '$'; }
bool continues_name(char c) { return starts_name(c) || is_digit(c); }

/// Byte offset behind the characters from `from` on that belong together.
template <bool (*belongs)(char)>
std::size_t behind(std::string_view text, std::size_t from) {
  while (from < text.size() && belongs(text[from])) ++from;
  return from;
}

bool begins_long_symbol(std::string_view text) {
  if (text.size() < 2) return false;
  return text[1] == '=' ? text[0] == '=' || text[0] == '<' || text[0] == '>' : text.starts_with("<>");
}

/// Length of E-3 at `from`; 0 where there is none.
std::size_t exponent_length(std::string_view text, std::size_t from) {
  if (from >= text.size() || capital(text[from]) != 'E') return 0;
  const bool is_signed = from + 1 < text.size() && (text[from + 1] == '+' || text[from + 1] == '-');
  const std::size_t first = from + (is_signed ? 2 : 1),
                    end = behind<is_digit>(text, std::min(first, text.size()));
  return end > first ? end - from : 0;
}

/// The number that a text starts with: 12, 1.5, .5, 2., 1.5E-3.
std::pair<TokenKind, std::size_t> number_in(std::string_view text) {
  const std::size_t whole = behind<is_digit>(text, 0);
  const bool has_point = whole < text.size() && text[whole] == '.';
  const std::size_t end = has_point ? behind<is_digit>(text, whole + 1) : whole;
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

}  // namespace

Cutter::Cutter(std::string_view text) : text_{text} {
  if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
}

Tokens Cutter::next() {
  tokens_.clear();
  for (bool is_whole = false; !is_whole && at_ < text_.size(); ++line_) {
    const std::size_t before = tokens_.size();
    read_line();
    // A line of a comment does not end what continues behind it.
    is_whole = tokens_.size() > before && !tokens_.back().is(",");
  }
  return tokens_;
}

void Cutter::read_line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  const std::string_view line = text_.substr(0, end);
  at_ = behind<is_blank>(line, at_);
  const bool is_header = line.substr(at_).starts_with('&');
  while (!is_header && at_ < end && line[at_] != ';') {
    const auto [kind, length] = first_of(line.substr(at_));
    tokens_.push_back({.text = line.substr(at_, length), .at = at_, .line = line_, .kind = kind});
    at_ = behind<is_blank>(line, at_ + length);
  }
  at_ = std::min(end + 1, text_.size());
}

std::pair<TokenKind, std::size_t> Cutter::first_of(std::string_view rest) const {
  const char c = rest[0];
  if (starts_name(c)) return {TokenKind::Name, behind<continues_name>(rest, 1)};
  if (c == '#') return {TokenKind::Constant, behind<continues_name>(rest, 1)};
  const bool begins_fraction = c == '.' && rest.size() > 1 && is_digit(rest[1]) && !follows_variable();
  if (is_digit(c) || begins_fraction) return number_in(rest);
  if (c == '"' || c == '\'') return quoted(rest);
  return {TokenKind::Symbol, begins_long_symbol(rest) ? 2 : 1};
}

std::pair<TokenKind, std::size_t> Cutter::quoted(std::string_view rest) const {
  const bool is_text = rest[0] == '"';
  const std::size_t closing = rest.find(rest[0], 1);
  if (closing != std::string_view::npos) return {is_text ? TokenKind::Text : TokenKind::Coded, closing + 1};
  if (is_text) throw Fault{at_, "a text that is not closed; close it in the same line"};
  return {TokenKind::Symbol, 1};
}

bool Cutter::follows_variable() const {
  return !tokens_.empty() && (tokens_.back().kind == TokenKind::Name || tokens_.back().is("]"));
}

bool Token::spells(std::string_view word) const { return std::ranges::equal(text, word, {}, capital); }

bool Token::is_same_name(const Token& other) const {
  return std::ranges::equal(text, other.text, {}, capital, capital);
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
    std::vector<Statement> statements;
    Cutter cutter(text);
    for (Tokens next = cutter.next(); !next.empty(); next = cutter.next())
      statements.emplace_back(next.begin(), next.end());
    return statements;
  } catch (const Fault& fault) {
    return std::unexpected(fault);
  }
}

}  // namespace truepose::krl
