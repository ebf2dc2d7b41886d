#include "proto/text/decimal.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace truepose::text {
namespace {

constexpr int kExactDigits = 15;  // of a double

constexpr std::array<double, kExactDigits + 1> kPowers{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                       1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
constexpr auto kWholePowers = [] {
  std::array<std::uint64_t, kExactDigits + 1> powers{};
  for (std::uint64_t power = 1; std::uint64_t & each : powers) {
    each = power;
    power *= 10;
  }
  return powers;
}();

struct Digits {
  std::uint64_t value = 0;
  int count = 0;  // 16 = that or more
};

// Both inlined, though called twice: most of a frame's decoding is here.

/// The digits at the beginning of eight characters, all at once: a byte each, two bytes each pair, and so on.
[[gnu::always_inline]] inline Digits digits_in(std::uint64_t characters) noexcept {
  if constexpr (std::endian::native == std::endian::big) characters = std::byteswap(characters);
  std::uint64_t digits = characters ^ 0x3030303030303030;
  // The high bit of a byte that is above 9, and perhaps of bytes after it.
  const std::uint64_t others = (digits | (digits + 0x7676767676767676)) & 0x8080808080808080;
  const int count = std::countr_zero(others) / 8;
  if (count == 0) return {};
  digits <<= 64 - 8 * count;  // zeros come first
  digits = (digits * 10 + (digits >> 8)) & 0x00FF00FF00FF00FF;
  digits = (digits * 100 + (digits >> 16)) & 0x0000FFFF0000FFFF;
  digits = (digits * 10'000 + (digits >> 32)) & 0x00000000FFFFFFFF;
  return {digits, count};
}

[[gnu::always_inline]] inline Digits digits_at(const char* at) noexcept {
  std::array<std::uint64_t, 2> characters;
  std::memcpy(&characters[0], at, 8);
  const Digits first = digits_in(characters[0]);
  if (first.count < 8) return first;
  std::memcpy(&characters[1], at + 8, 8);
  const Digits second = digits_in(characters[1]);
  if (second.count == 8) return {.count = 16};
  return {first.value * kWholePowers.data()[second.count] + second.value, 8 + second.count};
}

const char* behind_digits(const char* at) noexcept {
  while (*at >= '0' && *at <= '9') ++at;
  return at;
}

std::optional<double> read_long(const char*& at) noexcept {
  const char* end = behind_digits(at + (*at == '-'));
  if (*end == '.') end = behind_digits(end + 1);
  double value = 0;
  const auto [rest, error] = std::from_chars(at, end, value);
  if (error != std::errc{} || rest != end) return std::nullopt;
  at = end;
  return value;
}

/// "00" to "99".
constexpr auto kPairs = [] {
  std::array<char, 200> pairs{};
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i] = static_cast<char>('0' + (i % 2 == 0 ? i / 20 : i / 2 % 10));
  return pairs;
}();

}  // namespace

std::optional<double> read_decimal(const char*& at) noexcept {
  const bool negative = *at == '-';
  const char* const begin = at + negative;
  Digits digits = digits_at(begin);
  if (digits.count == 0) return std::nullopt;
  const char* end = begin + digits.count;
  int decimals = 0;
  if (digits.count < 8 && *end == '.') {
    const Digits fraction = digits_at(end + 1);
    if (fraction.count == 0) return std::nullopt;
    decimals = fraction.count;
    end += 1 + decimals;
    digits.count += decimals;
    if (digits.count <= kExactDigits)
      digits.value = digits.value * kWholePowers.data()[decimals] + fraction.value;
  }
  if (digits.count > kExactDigits || *end == '.') return read_long(at);
  at = end;
  const double value = static_cast<double>(digits.value) / kPowers.data()[decimals];
  return negative ? -value : value;
}

std::optional<std::int64_t> read_whole(const char*& at) noexcept {
  const Digits digits = digits_at(at);
  if (digits.count == 0 || digits.count > kExactDigits) return std::nullopt;
  at += digits.count;
  return static_cast<std::int64_t>(digits.value);
}

std::to_chars_result write_fixed(char* first, char* last, double value, int decimals) noexcept {
  // Below it a product is off by at most half its last place, 2.4e-7, and can be rounded up.
  constexpr double kGreatest = 4294967295;
  constexpr double kDoubt = 1e-6;
  constexpr std::ptrdiff_t kDigits = 10, kRoom = 32;
  const auto slow = [&] { return std::to_chars(first, last, value, std::chars_format::fixed, decimals); };
  if (decimals < 1 || decimals >= kDigits || last - first < kRoom) return slow();
  const double scaled = std::abs(value) * kPowers.data()[decimals];
  if (!(scaled < kGreatest)) return slow();
  auto number = static_cast<std::uint32_t>(scaled);
  const double left = scaled - number;
  if (std::abs(left - 0.5) < kDoubt) return slow();
  number += left > 0.5;

  std::array<char, kRoom> digits{};
  for (std::ptrdiff_t i = kDigits - 2; i >= 0; i -= 2, number /= 100)
    std::memcpy(digits.data() + i, kPairs.data() + 2 * (number % 100), 2);
  const char* const fraction = digits.data() + kDigits - decimals;
  const char* whole = digits.data();
  while (*whole == '0' && whole + 1 < fraction) ++whole;
  *first = '-';
  first += std::signbit(value);
  // More than there are, which costs less than to count them.
  std::memcpy(first, whole, kDigits);
  first += fraction - whole;
  *first++ = '.';
  std::memcpy(first, fraction, kDigits);
  return {first + decimals, std::errc{}};
}

}  // namespace truepose::text
