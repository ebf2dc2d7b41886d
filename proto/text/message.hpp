#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace truepose {

/// What is the same of all messages of a kind. Both sentences are formats of fmt for the same values, without
/// a capital and a full stop.
struct MessageKind {
  std::string_view code;        ///< stable, for programs
  std::string_view what;        ///< what is wrong (value, limit)
  std::string_view what_to_do;  ///< in the imperative
};

/// A fault, a refusal or a finding.
struct Message {
  std::string code;
  std::string what, what_to_do;
};

/// @tparam kKind  an enumerator; kind_of(kKind) is its row in the table of its part of the program
template <auto kKind, typename... Values>
Message message(const Values&... values) {
  constexpr MessageKind kRow = kind_of(kKind);
  return {std::string{kRow.code}, fmt::format(fmt::format_string<const Values&...>{kRow.what}, values...),
          fmt::format(fmt::format_string<const Values&...>{kRow.what_to_do}, values...)};
}

/// The text with a capital, unless it begins with a command, a file or a key.
std::string with_capital(std::string text);

/// "What is wrong (value, limit). What to do."
std::string sentences(const Message& message);

/// The sentences of one answer's messages. The same thing to do is said once.
class AnswerText {
 public:
  /// @return the sentences of the message, without what was said to be done
  std::string add(Message message);

 private:
  std::set<std::string> said_;
};

/// Whether each row of a table has a code of its own, in their order, that begins so, and both its sentences.
constexpr bool is_table(std::span<const MessageKind> kinds, std::string_view prefix) {
  return std::ranges::adjacent_find(kinds, std::ranges::greater_equal{}, &MessageKind::code) == kinds.end() &&
         std::ranges::all_of(kinds, [&](const MessageKind& kind) {
           return kind.code.starts_with(prefix) && !kind.what.empty() && !kind.what_to_do.empty() &&
                  !kind.what.ends_with('.') && !kind.what_to_do.ends_with('.');
         });
}

}  // namespace truepose
