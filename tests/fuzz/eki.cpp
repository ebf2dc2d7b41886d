// Documents of EKI. A stream gives the same ones however it is cut; what is accepted can be written and read.
#include <cmath>
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

/// What is written once is read and written the same, unless a number has more digits than a double keeps.
template <typename Decode>
void expect_round_trip(const std::string& document, Decode decode) {
  const auto message = decode(document);
  if (!message) {
    expect(!message.error().empty(), "a refusal says why");
    return;
  }
  constexpr std::size_t kLongestOfSaneNumbers = 700;
  const std::string text = eki::encode(*message);
  const auto again = decode(text);
  expect(again.has_value(), "what is written is read again: " + text);
  expect(again->index() == message->index(), "what is written is read as what it was");
  expect(text.size() > kLongestOfSaneNumbers || eki::encode(*again) == text,
         "what is written keeps its values: " + text);
}

}  // namespace

void eki(std::string_view input) {
  const std::vector<std::string> whole = documents({input});
  expect(documents(pieces_of(input)) == whole, "a stream gives the same documents however it is cut");
  for (const std::string& document : whole) {
    expect_round_trip(document, eki::decode_from_controller);
    expect_round_trip(document, eki::decode_to_controller);
  }
}

}  // namespace truepose::fuzz
