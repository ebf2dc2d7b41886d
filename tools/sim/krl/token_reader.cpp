#include "tools/sim/krl/token_reader.hpp"

namespace truepose::sim::krl {

const Token& TokenReader::peek(std::size_t ahead) const {
  static const Token kEnd;
  return at_ + ahead < statement_.tokens.size() ? statement_.tokens[at_ + ahead] : kEnd;
}

Token TokenReader::take() {
  if (at_end()) fail("the line ends too early");
  return statement_.tokens[at_++];
}

bool TokenReader::take_if(std::string_view word) {
  if (!next_is(word)) return false;
  ++at_;
  return true;
}

void TokenReader::expect(std::string_view word) {
  if (take_if(word)) return;
  fail(std::string(word) + " is expected" +
       (at_end() ? " at the end of the line" : " before " + peek().text));
}

std::string TokenReader::take_name(std::string_view what) {
  if (peek().kind != TokenKind::Name)
    fail(std::string(what) + " is expected" + (at_end() ? "" : " instead of " + peek().text));
  return take().text;
}

void TokenReader::expect_end() const {
  if (!at_end()) fail("the end of the line is expected before " + peek().text);
}

int TokenReader::line() const { return at_end() ? statement_.tokens.back().line : peek().line; }

void TokenReader::fail(const std::string& what) const { throw Fault{file_, line(), what}; }

}  // namespace truepose::sim::krl
