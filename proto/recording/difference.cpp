#include "proto/recording/difference.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace truepose::recording {
namespace {

/// So many equal bytes end a run of others.
constexpr std::size_t kWorthTaking = 4;

std::size_t common(std::string_view a, std::string_view b) {
  return static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
}

/// Bytes up to the end of the number that the text begins within.
std::size_t rest_of_number(std::string_view text) {
  return std::min(text.find_first_not_of("0123456789.+-eE"), text.size());
}

/// Where two texts that differ at once may agree again, in each of them.
struct Change {
  std::size_t before, now;
};

/// Numbers may have got other digits, and all else is taken to have kept its length.
Change change_at_front(std::string_view before, std::string_view now) {
  const Change numbers{rest_of_number(before), rest_of_number(now)};
  if (numbers.before > 0 || numbers.now > 0) return numbers;
  const std::size_t shorter = std::min(before.size(), now.size());
  for (std::size_t size = 1; size < shorter; ++size) {
    if (common(before.substr(size), now.substr(size)) >= kWorthTaking) return {size, size};
  }
  return {before.size(), now.size()};
}

std::optional<std::string_view> take_bytes(std::string_view& bytes) {
  const auto size = take_number(bytes);
  if (!size || *size > bytes.size()) return std::nullopt;
  const std::string_view taken = bytes.substr(0, *size);
  bytes.remove_prefix(*size);
  return taken;
}

/// @return whether there was as much
bool pass(std::string_view& bytes, std::uint64_t size) {
  if (size > bytes.size()) return false;
  bytes.remove_prefix(size);
  return true;
}

}  // namespace

void append_number(std::string& out, std::uint64_t number) {
  for (; number >= 0x80; number >>= 7) out += static_cast<char>(number | 0x80);
  out += static_cast<char>(number);
}

void append_signed(std::string& out, std::int64_t number) {
  append_number(out, (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63));
}

std::optional<std::uint64_t> take_number(std::string_view& bytes) {
  std::uint64_t number = 0;
  for (unsigned shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    number |= std::uint64_t{byte & 0x7fU} << shift;
    if (byte < 0x80) return number;
  }
  return std::nullopt;
}

std::optional<std::int64_t> take_signed(std::string_view& bytes) {
  const auto number = take_number(bytes);
  if (!number) return std::nullopt;
  return static_cast<std::int64_t>(*number >> 1) ^ -static_cast<std::int64_t>(*number & 1);
}

void append_difference(std::string& out, std::string_view before, std::string_view now) {
  while (!now.empty()) {
    const std::size_t same = common(before, now);
    before.remove_prefix(same);
    now.remove_prefix(same);
    const Change change = change_at_front(before, now);
    append_number(out, same);
    append_number(out, change.before);
    append_number(out, change.now);
    out += now.substr(0, change.now);
    before.remove_prefix(change.before);
    now.remove_prefix(change.now);
  }
}

std::optional<std::string> apply_difference(std::string_view before, std::string_view difference,
                                            std::size_t most) {
  std::string now;
  while (!difference.empty()) {
    const auto same = take_number(difference), passed = take_number(difference);
    const auto added = passed ? take_bytes(difference) : std::nullopt;
    if (!added || *same > before.size()) return std::nullopt;
    now += before.substr(0, *same);
    if (!pass(before, *same) || !pass(before, *passed)) return std::nullopt;
    now += *added;
    if (now.size() > most) return std::nullopt;
  }
  return now;
}

}  // namespace truepose::recording
