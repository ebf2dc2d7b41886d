#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <expected>
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

/// A time on the clock of the records.
struct Nanoseconds {
  std::int64_t form_of(drivers::TimePoint time) const { return drivers::nanoseconds_of(time); }
  drivers::TimePoint value_of(std::int64_t form) const { return drivers::time_of(form); }
};

/// A pose as the three upper rows of its matrix, which bring it back exactly.
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
