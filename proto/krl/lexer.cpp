#include "proto/krl/lexer.hpp"

#include <algorithm>

namespace truepose::krl {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool starts_name(char c) { return is_letter(c) || c == '_' || c == '$' || c == '#'; }
bool continues_name(char c) { return is_letter(c) || is_digit(c) || c == '_' || c == '$'; }
char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::size_t digits(std::string_view text, std::size_t from) {
  std::size_t end = from;
  while (end < text.size() && is_digit(text[end])) ++end;
  return end;
}

/// Length of the number that `text` starts with: 12, 1.5, .5, 2., 1.5E-3. 0 where there is none.
std::size_t number_length(std::string_view text) {
  std::size_t end = digits(text, 0);
  const bool has_whole_part = end > 0;
  if (end < text.size() && text[end] == '.') {
    const std::size_t after = digits(text, end + 1);
    if (has_whole_part || after > end + 1) end = after;
  }
  if (end == 0) return 0;
  if (end < text.size() && (text[end] == 'E' || text[end] == 'e')) {
    const std::size_t sign = end + 1;
    const bool is_signed = sign < text.size() && (text[sign] == '+' || text[sign] == '-');
    const std::size_t first = is_signed ? sign + 1 : sign;
    if (const std::size_t last = digits(text, first); last > first) end = last;
  }
  return end;
}

std::size_t name_length(std::string_view text) {
  if (!starts_name(text[0])) return 0;
  return static_cast<std::size_t>(std::ranges::find_if_not(text.substr(1), continues_name) - text.begin());
}

}  // namespace

bool Token::is(std::string_view word) const {
  return kind == TokenKind::Name && std::ranges::equal(text, word, {}, capital);
}

std::string in_capitals(std::string_view name) {
  std::string result(name);
  std::ranges::transform(result, result.begin(), capital);
  return result;
}

StatementReader::StatementReader(std::string_view text) : text_{text} {
  if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
}

std::expected<Tokens, Fault> StatementReader::next() {
  tokens_.clear();
  while (at_ < text_.size()) {
    if (const auto line = read_line(); !line) return std::unexpected(line.error());
    if (!tokens_.empty() && !tokens_.back().is(',')) break;
  }
  return Tokens(tokens_);
}

void StatementReader::add(TokenKind kind, std::size_t length) {
  tokens_.push_back({kind, text_.substr(at_, length), at_});
  at_ += length;
}

std::expected<void, Fault> StatementReader::read_line() {
  const std::size_t line_end = std::min(text_.find('\n', at_), text_.size());
  const auto rest = [&] { return text_.substr(at_, line_end - at_); };
  for (bool first = true; at_ < line_end;) {
    const char c = text_[at_];
    if (is_blank(c)) {
      ++at_;
      continue;
    }
    if (c == ';' || (c == '&' && first)) break;
    first = false;
    if (c == '"' || c == '\'') {
      const std::size_t closing = rest().find(c, 1);
      if (closing != std::string_view::npos) {
        add(c == '"' ? TokenKind::Text : TokenKind::Literal, closing + 1);
      } else if (c == '"') {
        return std::unexpected(Fault{at_, "a text that is not closed; close it in the same line"});
      } else {
        add(TokenKind::Symbol, 1);
      }
    } else if (const std::size_t number = number_length(rest()); number > 0) {
      add(TokenKind::Number, number);
    } else if (const std::size_t name = name_length(rest()); name > 0) {
      add(TokenKind::Name, name);
    } else {
      add(TokenKind::Symbol, 1);
    }
  }
  at_ = std::min(line_end + 1, text_.size());
  return {};
}

}  // namespace truepose::krl
