#include "proto/text/decimal.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace truepose::text {
namespace {

constexpr std::array<double, 10> kPowers{1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

struct Digits {
  std::uint64_t value = 0;
  int count = 0;  // 8 = that or more
};

/// The digits at the beginning of eight characters, all at once: a byte each, two bytes each pair, and so on.
Digits digits_at(const char* at) noexcept {
  std::uint64_t digits;
  std::memcpy(&digits, at, sizeof digits);
  if constexpr (std::endian::native == std::endian::big) digits = std::byteswap(digits);
  digits ^= 0x3030303030303030;
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

const char* behind_digits(const char* at) noexcept {
  while (*at >= '0' && *at <= '9') ++at;
  return at;
}

/// Of more digits than are read at once.
[[gnu::cold]] const char* read_long(const char* at, double& value) noexcept {
  const char* end = behind_digits(at + (*at == '-'));
  if (*end == '.') end = behind_digits(end + 1);
  const auto [rest, error] = std::from_chars(at, end, value);
  return error == std::errc{} && rest == end && *(end - 1) != '.' ? end : nullptr;
}

/// "00" to "99".
constexpr auto kPairs = [] {
  std::array<char, 200> pairs{};
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i] = static_cast<char>('0' + (i % 2 == 0 ? i / 20 : i / 2 % 10));
  return pairs;
}();

}  // namespace

const char* read_decimal(const char* at, double& value) noexcept {
  const bool negative = *at == '-';
  const char* const begin = at + negative;
  const Digits whole = digits_at(begin);
  if (whole.count == 0) return nullptr;
  if (whole.count == 8) return read_long(at, value);
  const char* end = begin + whole.count;
  Digits fraction;
  if (*end == '.') {
    fraction = digits_at(end + 1);
    if (fraction.count == 0) return nullptr;
    if (fraction.count == 8) return read_long(at, value);
    end += 1 + fraction.count;
  }
  const double power = kPowers.data()[fraction.count];
  // Exact below 2^53, which fourteen digits are. No branch: half of all signs would be a surprise.
  const double number = static_cast<double>(static_cast<std::int64_t>(whole.value)) * power +
                        static_cast<double>(static_cast<std::int64_t>(fraction.value));
  value = std::copysign(number / power, negative ? -1.0 : 1.0);
  return end;
}

const char* read_whole(const char* at, std::int64_t& value) noexcept {
  constexpr int kDigits = 18;  // of 63 bits
  const char* const end = behind_digits(at);
  if (end == at || end - at > kDigits) return nullptr;
  value = 0;
  for (; at < end; ++at) value = 10 * value + (*at - '0');
  return end;
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
