#include "proto/krl/token_reader.hpp"

namespace truepose::krl {

const Token TokenReader::kEnd{};

const Token& TokenReader::take() {
  if (at_end()) fail("the line ends too early");
  return tokens_[at_++];
}

bool TokenReader::take_if(std::string_view word) {
  if (!next_is(word)) return false;
  ++at_;
  return true;
}

void TokenReader::expect(std::string_view word) {
  if (take_if(word)) return;
  fail(std::string(word) + " is expected" +
       (at_end() ? " at the end of the line" : " before " + peek().word()));
}

std::string TokenReader::take_name(std::string_view what) {
  if (peek().kind != TokenKind::Name)
    fail(std::string(what) + " is expected" + (at_end() ? "" : " instead of " + peek().word()));
  return take().word();
}

void TokenReader::expect_end() const {
  if (!at_end()) fail("the end of the line is expected before " + peek().word());
}

void TokenReader::fail(const std::string& what) const { throw Fault{here().at, what}; }

}  // namespace truepose::krl
