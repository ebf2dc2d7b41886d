#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/clock.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/record/layout.hpp"

/// How records of the drivers say times and poses.
namespace truepose::record {

inline constexpr Whole kWhole64{INT64_MIN, INT64_MAX};
/// Bounds of what drivers reckon with: a time in ns that can be added to, a length of time in ms, a counter.
inline constexpr Whole kTime{0, INT64_MAX / 4}, kMs{0, 1'000'000'000}, kCounter{0, INT64_MAX / 2};

inline std::string digits_of(double number) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}
inline std::optional<double> number_of(const std::string& digits) {
  double number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, fault] = std::from_chars(digits.data(), end, number);
  return fault == std::errc{} && rest == end ? std::optional{number} : std::nullopt;
}

/// A time on the clock of the records.
struct Nanoseconds {
  std::int64_t form_of(drivers::TimePoint time) const { return drivers::nanoseconds_of(time); }
  drivers::TimePoint value_of(std::int64_t form) const { return drivers::time_of(form); }
};

/// Numbers in as many digits as bring them back exactly, as texts: JSON's own are read to the last digit but
/// one.
/// @tparam Numbers  a vector, or an array
template <class Numbers>
struct Digits {
  std::vector<std::string> form_of(const Numbers& numbers) const {
    std::vector<std::string> form;
    for (const double number : numbers) form.push_back(digits_of(number));
    return form;
  }
  std::string_view fault(const std::vector<std::string>& form) const {
    if (!fits(form.size())) return "expected as many numbers as it has";
    const bool numbers =
        std::ranges::all_of(form, [](const auto& each) { return number_of(each).has_value(); });
    return numbers ? "" : "expected numbers";
  }
  Numbers value_of(const std::vector<std::string>& form) const {
    Numbers numbers;
    if constexpr (requires { numbers.resize(0); }) numbers.resize(static_cast<Eigen::Index>(form.size()));
    std::ranges::transform(form, numbers.begin(),
                           [](const std::string& digits) { return *number_of(digits); });
    return numbers;
  }

 private:
  static bool fits(std::size_t size) {
    if constexpr (requires { Numbers::MaxSizeAtCompileTime; }) {
      const auto most = static_cast<std::size_t>(Numbers::MaxSizeAtCompileTime);
      return Numbers::SizeAtCompileTime == Eigen::Dynamic ? size <= most : size == most;
    } else {
      return size == Numbers{}.size();
    }
  }
};

/// The same of one.
struct OneInDigits {
  std::string form_of(double number) const { return digits_of(number); }
  std::string_view fault(const std::string& form) const { return number_of(form) ? "" : "expected a number"; }
  double value_of(const std::string& form) const { return *number_of(form); }
};

/// A pose as the three upper rows of its matrix.
struct Rows {
  std::vector<double> form_of(const Eigen::Isometry3d& X) const {
    std::vector<double> numbers;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) numbers.push_back(X(row, column));
    return numbers;
  }
};

template <class Record>
std::string text_of(const Record& x) {
  return control::json_text(to_json(x));
}

/// @param name  how errors call it
template <class Record>
std::expected<Record, std::string> read_text(std::string_view text, const std::string& name) {
  const auto document = control::parse_json(text);
  if (!document) return std::unexpected(name + ": " + document.error());
  return from_json<Record>(*document, name);
}

}  // namespace truepose::record
