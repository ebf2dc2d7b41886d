#include "proto/text/message.hpp"

namespace truepose {
namespace {

std::string with_full_stop(std::string text) {
  return text.ends_with('.') || text.ends_with('?') ? text : text + ".";
}

}  // namespace

std::string with_capital(std::string text) {
  const std::size_t end = text.find_first_not_of("abcdefghijklmnopqrstuvwxyz");
  const bool is_word = end != 0 && (end == std::string::npos || std::string_view{" ,:;"}.contains(text[end]));
  if (is_word && !text.empty() && !text.starts_with("truepose"))
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string sentences(const Message& message) {
  const std::string what = with_full_stop(message.what);
  return message.what_to_do.empty() ? what : what + " " + with_full_stop(with_capital(message.what_to_do));
}

std::string AnswerText::add(Message message) {
  if (!said_.insert(message.what_to_do).second) message.what_to_do.clear();
  return sentences(message);
}

}  // namespace truepose
