#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace truepose::xml {

struct Attribute {
  std::string_view name;
  std::string_view value;  ///< as written: entities are not expanded
};

/// Walks through one XML document of the kind that KUKA controllers write: elements, attributes and text in
/// ASCII or UTF-8, with comments and processing instructions skipped. Checks that tags pair up and that
/// nothing but white space surrounds the root. A byte order mark is skipped, and the document ends at its
/// first NUL: senders written in C end a text so, or fill their block with it. No allocation, no exception;
/// every view points into the document.
class Scanner {
 public:
  enum class Event {
    Open,       ///< name() and attributes() are those of the element
    Text,       ///< text(), never only white space
    Close,      ///< name(); also comes after the Open of <Element/>
    End,        ///< the document is complete and well formed
    Malformed,  ///< at offset(); every further call says so again
  };

  explicit Scanner(std::string_view document) noexcept;

  Event next() noexcept;

  std::string_view name() const noexcept { return name_; }
  std::span<const Attribute> attributes() const noexcept { return {attributes_.data(), attribute_count_}; }
  /// False where the element has more attributes than are kept: attributes() are the first of them.
  bool has_all_attributes() const noexcept { return has_all_attributes_; }
  std::string_view text() const noexcept { return text_; }
  /// Elements open now: 1 after the Open of the root, 0 after its Close.
  std::size_t depth() const noexcept { return depth_; }
  std::size_t offset() const noexcept { return position_; }

 private:
  static constexpr std::size_t kMaxDepth = 16;
  static constexpr std::size_t kMaxAttributes = 32;

  Event malformed() noexcept;
  Event read_tag() noexcept;
  Event read_closing_tag() noexcept;
  bool read_attribute() noexcept;
  bool skip_past(std::string_view end) noexcept;
  void skip_space() noexcept;
  std::string_view read_name() noexcept;
  bool at(char c) const noexcept { return position_ < document_.size() && document_[position_] == c; }

  std::string_view document_;
  std::size_t position_ = 0;
  std::size_t depth_ = 0;
  std::array<std::string_view, kMaxDepth> open_;
  std::string_view name_;
  std::string_view text_;
  std::array<Attribute, kMaxAttributes> attributes_;
  std::size_t attribute_count_ = 0;
  bool has_all_attributes_ = true;
  bool close_pending_ = false;  // an element of the form <Element/> was opened
  bool root_seen_ = false;
  bool malformed_ = false;
};

constexpr bool is_space(char c) noexcept { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/// Without the white space around it.
constexpr std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// The whole text as one number; white space around it and one plus sign are allowed, as XML Schema and C
/// write them. Never NaN or infinite.
template <typename Number>
requires std::integral<Number> || std::floating_point<Number> std::optional<Number> to_number(
    std::string_view text)
noexcept {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::floating_point<Number>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

/// The same for a whole number that may be written as a decimal one: "1.000000", as EKI writes what it keeps
/// as a REAL.
std::optional<std::int64_t> to_whole_number(std::string_view text) noexcept;

}  // namespace truepose::xml
