#pragma once

#include <string>
#include <string_view>

#include "proto/krl/lexer.hpp"

namespace truepose::krl {

/// Reads the tokens of one statement in order. Fails where something else stands than is expected.
class TokenReader {
 public:
  /// @param tokens  outlive the reader
  explicit TokenReader(Tokens tokens) : tokens_{tokens} {}
  virtual ~TokenReader() = default;

  bool at_end() const { return at_ == tokens_.size(); }
  /// The token `ahead` of the next; an empty symbol behind the end.
  const Token& peek(std::size_t ahead = 0) const {
    return at_ + ahead < tokens_.size() ? tokens_[at_ + ahead] : kEnd;
  }
  bool next_is(std::string_view word) const { return peek().is(word); }
  const Token& take();
  bool take_if(std::string_view word);
  void expect(std::string_view word);
  /// @param what  for the message: "a variable"
  /// @return it in capitals
  std::string take_name(std::string_view what);
  void expect_end() const;
  Tokens rest() const { return tokens_.subspan(at_); }
  /// Byte offset behind the token that was taken last.
  std::size_t end() const { return tokens_[at_ - 1].end(); }

  /// Throws Fault at the next token; a front end that names its places otherwise throws its own.
  [[noreturn]] virtual void fail(const std::string& what) const;

 protected:
  /// The next token, at the end the last.
  const Token& here() const { return tokens_[at_end() ? at_ - 1 : at_]; }

 private:
  static const Token kEnd;

  Tokens tokens_;
  std::size_t at_ = 0;
};

}  // namespace truepose::krl
