#include "proto/xml/scanner.hpp"

#include <algorithm>

namespace truepose::xml {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

// Digits may begin a name: KUKA's I/O elements have attributes such as 01="1".
constexpr std::array<bool, 256> kNameCharacters = [] {
  std::array<bool, 256> table{};
  for (std::size_t c = 0; c < table.size(); ++c) {
    table[c] = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.' || c == ':' || c >= 0x80;
  }
  return table;
}();

bool is_name_character(char c) { return kNameCharacters[static_cast<unsigned char>(c)]; }

}  // namespace

std::optional<std::int64_t> to_whole_number(std::string_view text) noexcept {
  if (const auto whole = to_number<std::int64_t>(text)) return whole;
  constexpr double kExact = 9007199254740992;  // 2^53: below it a double keeps every whole number
  const auto decimal = to_number<double>(text);
  if (!decimal || std::abs(*decimal) > kExact || std::trunc(*decimal) != *decimal) return std::nullopt;
  return static_cast<std::int64_t>(*decimal);
}

Scanner::Scanner(std::string_view document) noexcept : document_{document.substr(0, document.find('\0'))} {
  if (document_.starts_with(kByteOrderMark)) position_ = kByteOrderMark.size();
}

Scanner::Event Scanner::malformed() noexcept {
  malformed_ = true;
  return Event::Malformed;
}

void Scanner::skip_space() noexcept {
  while (position_ < document_.size() && is_space(document_[position_])) ++position_;
}

bool Scanner::skip_past(std::string_view end) noexcept {
  const std::size_t found = document_.find(end, position_);
  if (found == std::string_view::npos) return false;
  position_ = found + end.size();
  return true;
}

std::string_view Scanner::read_name() noexcept {
  const std::size_t begin = position_;
  std::size_t end = begin;
  while (end < document_.size() && is_name_character(document_[end])) ++end;
  position_ = end;
  return document_.substr(begin, end - begin);
}

Scanner::Event Scanner::next() noexcept {
  if (malformed_) return Event::Malformed;
  if (close_pending_) {
    close_pending_ = false;
    --depth_;
    return Event::Close;
  }
  for (;;) {
    const std::size_t begin = position_;
    position_ = std::min(document_.find('<', begin), document_.size());
    const std::string_view between = trimmed(document_.substr(begin, position_ - begin));
    if (!between.empty()) {
      if (depth_ == 0) return malformed();
      text_ = between;
      return Event::Text;
    }
    if (position_ == document_.size()) return depth_ == 0 && root_seen_ ? Event::End : malformed();

    const std::string_view rest = document_.substr(position_);
    if (rest.starts_with("<!--")) {
      position_ += 4;
      if (!skip_past("-->")) return malformed();
    } else if (rest.starts_with("<?")) {
      if (!skip_past("?>")) return malformed();
    } else if (rest.starts_with("</")) {
      return read_closing_tag();
    } else {
      return read_tag();
    }
  }
}

Scanner::Event Scanner::read_closing_tag() noexcept {
  position_ += 2;
  name_ = read_name();
  skip_space();
  if (depth_ == 0 || name_ != open_[depth_ - 1] || !at('>')) return malformed();
  ++position_;
  --depth_;
  return Event::Close;
}

Scanner::Event Scanner::read_tag() noexcept {
  ++position_;
  name_ = read_name();
  if (name_.empty() || depth_ == kMaxDepth || (depth_ == 0 && root_seen_)) return malformed();
  attribute_count_ = 0;
  has_all_attributes_ = true;
  for (;;) {
    const std::size_t before = position_;
    skip_space();
    if (at('>')) break;
    if (at('/')) {
      ++position_;
      if (!at('>')) return malformed();
      close_pending_ = true;
      break;
    }
    if (position_ == before || !read_attribute()) return malformed();
  }
  ++position_;
  root_seen_ = true;
  open_[depth_++] = name_;
  return Event::Open;
}

bool Scanner::read_attribute() noexcept {
  const std::string_view name = read_name();
  if (name.empty()) return false;
  skip_space();
  if (!at('=')) return false;
  ++position_;
  skip_space();
  if (!at('"') && !at('\'')) return false;
  const char quote = document_[position_++];
  const std::size_t begin = position_;
  std::size_t end = begin;
  while (end < document_.size() && document_[end] != quote && document_[end] != '<') ++end;
  position_ = end;
  if (!at(quote)) return false;
  has_all_attributes_ = attribute_count_ < kMaxAttributes;
  if (has_all_attributes_) attributes_[attribute_count_++] = {name, document_.substr(begin, end - begin)};
  ++position_;
  return true;
}

}  // namespace truepose::xml
