// Documents of EKI. A stream gives the same ones however it is cut; what is accepted can be written and read.
#include <algorithm>
#include <expected>
#include <string>
#include <variant>
#include <vector>

#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"
#include "tests/fuzz/pieces.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

/// The documents of a stream, up to the first error.
std::vector<std::string> documents(const std::vector<std::string_view>& pieces) {
  eki::DocumentSplitter splitter;
  std::vector<std::string> documents;
  for (const std::string_view piece : pieces) {
    splitter.feed(piece);
    while (true) {
      const auto document = splitter.next();
      if (!document) return documents;
      if (!*document) break;
      documents.push_back(**document);
    }
  }
  return documents;
}

/// Whether a number has so many digits that six decimals behind them are more than a double keeps.
bool has_long_number(std::string_view text) {
  constexpr int kMostDigits = 9;
  int digits = 0;
  return std::ranges::any_of(text, [&](char c) {
    digits = c >= '0' && c <= '9' ? digits + 1 : 0;
    return digits > kMostDigits;
  });
}

template <typename Message>
using Decoded = std::expected<std::vector<Message>, std::string>;

Decoded<eki::FromController> from_controller(const std::string& document) {
  return eki::decode_from_controller(document);
}
Decoded<eki::ToController> to_controller(const std::string& document) {
  const auto message = eki::decode_to_controller(document);
  if (!message) return std::unexpected(message.error());
  return std::vector{*message};
}

/// What is written once is read and written the same.
template <typename Message>
void expect_round_trip(const std::string& document, Decoded<Message> (*decode)(const std::string&)) {
  const Decoded<Message> messages = decode(document);
  if (!messages) {
    expect(!messages.error().empty(), "a refusal says why");
    return;
  }
  for (const Message& message : *messages) {
    const std::string text = eki::encode(message);
    const Decoded<Message> again = decode(text);
    expect(again && again->size() == 1 && again->front().index() == message.index(),
           "what is written is read as what it was: " + text);
    expect(has_long_number(text) || eki::encode(again->front()) == text,
           "what is written keeps its values: " + text);
  }
}

}  // namespace

void eki(std::string_view input) {
  const std::vector<std::string> whole = documents({input});
  expect(documents(pieces_of(input)) == whole && documents(bytes_of(input)) == whole,
         "a stream gives the same documents however it is cut");
  for (const std::string& document : whole) {
    expect_round_trip(document, from_controller);
    expect_round_trip(document, to_controller);
  }
}

}  // namespace truepose::fuzz
