#include "proto/krl/rewrite.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace truepose::krl {
namespace {

constexpr int kDecimals = 9;
constexpr double kHalfLastDecimal = 0.5e-9;

/// Whether a digit put behind `before` would be read as part of a name or a number.
bool runs_on(char before) {
  return (before >= 'A' && before <= 'Z') || (before >= 'a' && before <= 'z') ||
         (before >= '0' && before <= '9') || before == '_' || before == '$';
}

}  // namespace

std::string rewritten(std::string_view text, std::vector<Edit> edits) {
  std::ranges::sort(edits, {}, &Edit::begin);
  std::string result;
  result.reserve(text.size() + 16 * edits.size());
  std::size_t from = 0;
  for (const Edit& edit : edits) {
    result += text.substr(from, edit.begin - from);
    // The sign of "X-5" kept its number apart from the name.
    if (!result.empty() && runs_on(result.back()) && edit.text[0] != '-' && edit.text[0] != ',')
      result += ' ';
    result += edit.text;
    from = edit.end;
  }
  result += text.substr(from);
  return result;
}

std::string number_text(double value) {
  // Room for the largest double in full.
  std::array<char, 330> buffer;
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, kDecimals);
  std::string text(buffer.data(), end.ptr);
  const std::size_t last = std::max(text.find_last_not_of('0'), text.find('.') + 1);
  text.resize(last + 1);
  return text == "-0.0" ? "0.0" : text;
}

bool is_changed(const Number& number, double value) {
  return std::abs(value - number.value) > kHalfLastDecimal;
}

}  // namespace truepose::krl
