#include "proto/rsi/frame_layout.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "proto/text/decimal.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

using Event = xml::Scanner::Event;
using Word = std::uint64_t;
static_assert(text::kDecimalPadding <= sizeof(Word));  // behind a frame

/// The first bytes of a word, so many of them.
constexpr auto kFirstBytes = [] {
  std::array<Word, sizeof(Word)> masks{};
  for (std::size_t bytes = 0; bytes < masks.size(); ++bytes) {
    std::array<unsigned char, sizeof(Word)> mask{};
    std::fill_n(mask.begin(), bytes, 0xFF);
    masks[bytes] = std::bit_cast<Word>(mask);
  }
  return masks;
}();

Word word_at(const char* bytes) noexcept {
  Word word;
  std::memcpy(&word, bytes, sizeof word);
  return word;
}

std::optional<std::size_t> place_of(std::string_view name, std::span<const std::string_view> names) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

/// Of an attribute of an element below the root.
FrameLayout::Found FrameLayout::slot_of(std::string_view element, std::string_view attribute) noexcept {
  if (element == "Delay" && attribute == "D") return {Slot::Delay};
  if (element == kProgramElement) {
    const auto place = place_of(attribute, kProgramNames);
    return place ? Found{Slot::Program, *place} : Found{};
  }
  for (std::size_t i = 0; i < kSixElements.size(); ++i) {
    if (kSixElements[i].name != element) continue;
    const auto place = place_of(attribute, kSixElements[i].attributes.names);
    return place ? Found{Slot::Six, i * kAxes + *place} : Found{};
  }
  return {};
}

void FrameLayout::learn(std::string_view frame) noexcept {
  steps_ = words_ = 0;
  known_ = false;
  shape_ = {};
  xml::Scanner scanner{frame};
  std::size_t at = 0;  // behind the slot before
  const auto add = [&](Found found, std::string_view slot) {
    const auto begin = static_cast<std::size_t>(slot.data() - frame.data());
    if (!add_step(found, frame.substr(at, begin - at))) return false;
    at = begin + slot.size();
    return true;
  };
  for (bool in_ipoc = false;;) {
    const Event event = scanner.next();
    if (event == Event::Malformed || !scanner.has_all_attributes()) return;
    if (event == Event::End) break;
    if (event == Event::Text) {
      if (!add(in_ipoc ? Found{Slot::Ipoc} : Found{}, scanner.text())) return;
      // Skipped is what comes before the next tag, so that the text may be shorter another time.
      if (!in_ipoc) at = std::min(frame.find('<', at), frame.size());
    }
    const bool below_root = event == Event::Open && scanner.depth() == 2;
    in_ipoc = below_root && scanner.name() == "IPOC";
    if (event != Event::Open) continue;
    for (const xml::Attribute& attribute : scanner.attributes()) {
      const Found found = below_root ? slot_of(scanner.name(), attribute.name) : Found{};
      // White space in a number's quotes is no part of it.
      const bool skipped = found.slot == Slot::Skipped;
      if (!add(found, skipped ? attribute.value : xml::trimmed(attribute.value))) return;
    }
  }
  known_ = add_step({Slot::End}, frame.substr(at, frame.find('\0', at) - at));
}

/// @param text  between the slot before and this one
bool FrameLayout::add_step(Found found, std::string_view text) noexcept {
  const std::size_t words = (text.size() + sizeof(Word) - 1) / sizeof(Word);
  if (steps_ == all_steps_.size() || words_ + words > all_words_.size()) return false;
  all_steps_[steps_++] = {.slot = found.slot,
                          .place = static_cast<std::uint8_t>(found.place),
                          .text = static_cast<std::uint16_t>(words_),
                          .text_bytes = static_cast<std::uint16_t>(text.size())};
  std::fill_n(all_words_.begin() + static_cast<std::ptrdiff_t>(words_), words, Word{0});
  if (words > 0) std::memcpy(&all_words_[words_], text.data(), text.size());
  words_ += words;
  switch (found.slot) {
    case Slot::Six:
      shape_.six[found.place / kAxes].emplace();
      break;
    case Slot::Delay:
      shape_.delay.emplace();
      break;
    case Slot::Program:
      shape_.program[found.place].emplace();
      break;
    case Slot::Ipoc:
    case Slot::Skipped:
    case Slot::End:
      break;
  }
  return true;
}

std::optional<RobotFrame> FrameLayout::read(std::string_view frame) noexcept {
  if (!known_ || frame.size() > kMaxFrameBytes) return std::nullopt;
  std::memcpy(frame_.data(), frame.data(), frame.size());
  std::memset(frame_.data() + frame.size(), 0, frame_.size() - kMaxFrameBytes);
  WireNumbers numbers = shape_;
  const char* at = frame_.data();
  const Step* step = all_steps_.data();
  for (;; ++step) {
    at = behind_text(*step, at);
    if (!at) return std::nullopt;
    if (step->slot == Slot::End) break;
    at = behind_slot(*step, at, numbers);
    if (!at) return std::nullopt;
  }
  // As for the scanner, a frame ends at its first NUL.
  if (*at != '\0') return std::nullopt;
  return robot_frame(numbers);
}

/// @return behind the step's text, null where another stands there
const char* FrameLayout::behind_text(const Step& step, const char* at) const noexcept {
  const Word* words = all_words_.data() + step.text;
  std::size_t left = step.text_bytes;
  for (; left >= sizeof(Word); left -= sizeof(Word), at += sizeof(Word), ++words) {
    if (word_at(at) != *words) return nullptr;
  }
  if (left == 0) return at;
  return ((word_at(at) ^ *words) & kFirstBytes.data()[left]) == 0 ? at + left : nullptr;
}

/// @return behind the slot, null where it cannot be read here
const char* FrameLayout::behind_slot(const Step& step, const char* at, WireNumbers& numbers) const noexcept {
  switch (step.slot) {
    case Slot::Six:
      return text::read_decimal(at, numbers.six.data()[step.place / kAxes]->data()[step.place % kAxes]);
    case Slot::Delay:
      return text::read_whole(at, *numbers.delay);
    case Slot::Program:
      return text::read_whole(at, *numbers.program.data()[step.place]);
    case Slot::Ipoc: {
      std::int64_t ipoc = 0;
      const char* const end = text::read_whole(at, ipoc);
      numbers.ipoc = static_cast<std::uint64_t>(ipoc);
      return end;
    }
    case Slot::Skipped: {
      // A value ends at its quote, a text at a tag; in neither is a tag or a NUL.
      const char end = *reinterpret_cast<const char*>(all_words_.data() + (&step + 1)->text);
      while (*at != end && *at != '<' && *at != '\0') ++at;
      return *at == end ? at : nullptr;
    }
    case Slot::End:
      break;
  }
  return nullptr;
}

std::expected<RobotFrame, FrameError> RobotFrameDecoder::decode(std::string_view datagram) noexcept {
  if (const auto frame = layout_.read(datagram)) return *frame;
  auto frame = decode_robot_frame(datagram);
  if (frame && !frame->unread) layout_.learn(datagram);
  return frame;
}

}  // namespace truepose::rsi
