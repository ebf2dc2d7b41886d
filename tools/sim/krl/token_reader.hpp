#pragma once

#include <string>
#include <string_view>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/lexer.hpp"

namespace truepose::sim::krl {

/// Reads the tokens of one statement in order. Throws Fault where something else stands than is expected.
class TokenReader {
 public:
  /// @param file, statement  outlive the reader
  TokenReader(const std::string& file, const Statement& statement) : file_{file}, statement_{statement} {}

  bool at_end() const { return at_ == statement_.tokens.size(); }
  /// The token `ahead` of the next; an empty symbol behind the end.
  const Token& peek(std::size_t ahead = 0) const;
  bool next_is(std::string_view word) const { return peek().is(word); }
  Token take();
  bool take_if(std::string_view word);
  void expect(std::string_view word);
  /// @param what  for the message: "a variable"
  std::string take_name(std::string_view what);
  void expect_end() const;

  int line() const;
  const std::string& file() const { return file_; }
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const std::string& file_;
  const Statement& statement_;
  std::size_t at_ = 0;
};

}  // namespace truepose::sim::krl
