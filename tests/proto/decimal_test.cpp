#include "proto/text/decimal.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/trials.hpp"

namespace truepose::text {
namespace {

/// What std::from_chars makes of the text, bit for bit, and where it ends; an exponent is left to others.
void expect_as_from_chars(const std::string& text) {
  const std::string padded = text + std::string(kDecimalPadding, '\0');
  double value = 0;
  const char* const at = read_decimal(padded.data(), value);
  if (!at) return;
  double expected = 0;
  const auto [end, error] =
      std::from_chars(padded.data(), padded.data() + text.size(), expected, std::chars_format::fixed);
  EXPECT_EQ(error, std::errc{}) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected)) << text;
  EXPECT_EQ(at, end) << text;
}

std::optional<double> decimal(std::string text) {
  text.append(kDecimalPadding, '\0');
  double value = 0;
  return read_decimal(text.data(), value) ? std::optional{value} : std::nullopt;
}

TEST(Decimal, OfFrontDoorNumbersIsRead) {
  for (const char* text : {"0", "-0", "0.0", "-0.0000", "1765.0000", "-350.0000", "007.50", "0.1", "12345678",
                           "123456789012345", "1234567.12345678", "0.000000000000001", "99999999.9999999"}) {
    EXPECT_TRUE(decimal(text)) << text;
    expect_as_from_chars(text);
  }
}

TEST(Decimal, OfManyDigitsIsReadAsWell) {
  for (const char* text :
       {"1234567890123456", "9007199254740993", "0.30000000000000004", "123456789.123456789",
        "18446744073709551617", "100000000000000000000000", "2.2250738585072014000000000000000000001"}) {
    EXPECT_TRUE(decimal(text)) << text;
    expect_as_from_chars(text);
  }
  EXPECT_TRUE(decimal(std::string(300, '1')));
  EXPECT_FALSE(decimal(std::string(400, '1'))) << "beyond the greatest double";
}

TEST(Decimal, ThatIsWrittenInAnotherWayIsLeftToOthers) {
  for (const char* text : {"", "-", "--1", "+1", ".5", "-.5", "1.", "1.x", "123456789.", "123456789.x", "x",
                           " 1", "nan", "inf", "/", ":"})
    EXPECT_FALSE(decimal(text)) << text;
}

TEST(Decimal, IsReadAsFromCharsDoesOnRandomNumbers) {
  constexpr unsigned kSeed = 20263;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random{kSeed};
  const auto digits = [&](std::uint64_t most) {
    std::string text(1 + random() % most, '0');
    for (char& c : text) c = static_cast<char>('0' + random() % 10);
    return text;
  };
  for (int round = 0; round < 200'000 / share(); ++round) {
    std::string text = (random() % 2 == 0 ? "-" : "") + digits(random() % 8 == 0 ? 20 : 8);
    if (random() % 4 != 0) text += "." + digits(random() % 8 == 0 ? 20 : 8);
    ASSERT_TRUE(decimal(text)) << text;
    ASSERT_NO_FATAL_FAILURE(expect_as_from_chars(text));
    expect_as_from_chars(text + "\" A2=\"1");
    expect_as_from_chars(text + "e5");
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Decimal, StopsAtTheFirstCharacterThatIsNoDigit) {
  for (int c = 1; c < 256; ++c) {
    if ((c >= '0' && c <= '9') || c == '.') continue;
    for (const std::string& number : {std::string{"1"}, std::string{"1234567"}, std::string{"12345678"},
                                      std::string{"12.5"}, std::string{"123456789.125"}}) {
      std::string text = number + static_cast<char>(c) + "999" + std::string(kDecimalPadding, '\0');
      double value = 0;
      EXPECT_EQ(read_decimal(text.data(), value), text.data() + number.size()) << c;
      EXPECT_EQ(value, std::stod(number)) << c;
    }
  }
}

TEST(Decimal, OfWholeNumbersHasUpToEighteenDigits) {
  const auto whole = [](std::string text) {
    text.append(kDecimalPadding, '\0');
    std::int64_t value = 0;
    return read_whole(text.data(), value) ? std::optional{value} : std::nullopt;
  };
  EXPECT_EQ(whole("0"), 0);
  EXPECT_EQ(whole("4208163</IPOC>"), 4208163);
  EXPECT_EQ(whole("999999999999999999"), 999999999999999999);
  for (const char* text : {"", "-1", "+1", "1000000000000000000", "18446744073709551615", "x"})
    EXPECT_EQ(whole(text), std::nullopt) << text;
}

/// The same bytes, the same end and the same error, whatever room there is.
void expect_as_to_chars(double value, int decimals, std::size_t room = 400) {
  std::vector<char> ours(room), theirs(room);
  const auto is = write_fixed(ours.data(), ours.data() + room, value, decimals);
  const auto expected =
      std::to_chars(theirs.data(), theirs.data() + room, value, std::chars_format::fixed, decimals);
  ASSERT_EQ(is.ec, expected.ec) << value << ' ' << decimals << ' ' << room;
  if (is.ec != std::errc{}) return;
  ASSERT_EQ(std::string(ours.data(), is.ptr), std::string(theirs.data(), expected.ptr))
      << value << ' ' << decimals;
}

TEST(Fixed, IsWrittenAsToCharsDoesAtTheEdges) {
  using Limits = std::numeric_limits<double>;
  std::vector<double> values{0,
                             0.5,
                             1,
                             1.5,
                             2.5,
                             0.125,
                             0.375,
                             0.0625,
                             0.1,
                             0.3,
                             4294.967295,
                             4294.967296,
                             4294967295.5,
                             999999.9999995,
                             0.9999995,
                             9.9999995,
                             1e15,
                             1e22,
                             1e300,
                             5e-7,
                             4.9999999999e-7,
                             Limits::min(),
                             Limits::denorm_min(),
                             Limits::max(),
                             Limits::infinity(),
                             Limits::quiet_NaN()};
  for (int k = 0; k < 2000; ++k) values.push_back((k + 0.5) * 1e-6);  // as near to a tie as a double can be
  for (const double value : values) {
    for (const double near : {value, std::nextafter(value, 0.0), std::nextafter(value, Limits::infinity())}) {
      for (int decimals = 0; decimals <= 15; ++decimals) {
        ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(near, decimals));
        ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(-near, decimals));
      }
    }
  }
}

TEST(Fixed, IsWrittenAsToCharsDoesOnRandomNumbers) {
  constexpr unsigned kSeed = 20264;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> exponent{-12, 12}, mantissa{-1, 1};
  for (int round = 0; round < 300'000 / share(); ++round) {
    const double value = mantissa(random) * std::pow(10, exponent(random));
    ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(value, static_cast<int>(random() % 16)));
    ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(value, 6));
    ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(std::bit_cast<double>(random()), 6));
  }
}

TEST(Fixed, WritesNothingBehindTheRoomThatThereIs) {
  for (std::size_t room = 0; room < 48; ++room) {
    for (const double value : {0.0, -0.012345, 180.0, -4294.0, 1e9})
      ASSERT_NO_FATAL_FAILURE(expect_as_to_chars(value, 6, room));
  }
}

}  // namespace
}  // namespace truepose::text
