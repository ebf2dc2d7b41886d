#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/yaml_reader.hpp"
#include "core/math/refraction.hpp"
#include "core/plan/scene.hpp"
#include "proto/record/forms.hpp"

/// Records in YAML by their layouts (proto/record/layout.hpp). One that is written reads back as exactly what
/// it was: every number has the digits that bring it back, a text stands in double quotes.
namespace truepose::config {

// A layout is made of the words of record, here and in every file that says one.
using namespace record;

/// What WriteIo makes of a record in YAML: maps and lists of plain values on one line, and what holds such
/// ones line by line.
struct YamlText {
  struct Value {
    std::string text;
    bool is_plain = false;  ///< no list and no map
    bool is_block = false;  ///< of several lines
  };

  static Value number(double number);
  static Value whole(std::int64_t number) { return {std::to_string(number), true}; }
  static Value seed(std::uint64_t number) { return {std::to_string(number), true}; }
  static Value boolean(bool flag) { return {flag ? "true" : "false", true}; }
  static Value text(std::string_view text);
  static Value word(std::string_view word) { return {std::string{word}, true}; }
  static Value list(const std::vector<Value>& elements);
  static Value record(const std::vector<std::pair<std::string, Value>>& members);
};

template <class Record>
std::string yaml_of(const Record& x) {
  return WriteIo<YamlText>::value(x).text;
}

/// Throws ConfigError.
template <class T, class... How>
void read_value(const YamlValue& value, T& x, const How&... how) {
  ReadIo<YamlValue>::read(value, x, how...);
}

/// Numbers in rows that all have the same number of columns.
struct Rows {
  std::vector<int> columns;  ///< one of these

  std::vector<std::vector<double>> form_of(const Eigen::MatrixXd& A) const;
  void read(const YamlValue& value, Eigen::MatrixXd& A) const;
};

// ---- What surrounds an arm and its tracker

void layout(auto& io, Is<Air> auto& x) {
  io("temperature_c", x.temperature_c, Range{-20, 60});
  io("pressure_mbar", x.pressure_mbar, Range{500, 1100});
  io("humidity_percent", x.humidity_percent, Range{0, 100});
}

void layout(auto& io, Is<Capsule> auto& x) {
  io("from", x.from_mm, kPoint);
  io.on_read(x, [](auto& sphere) { sphere.to_mm = sphere.from_mm; });
  io.optional("to", x.to_mm, kPoint);
  io("radius", x.radius_mm, Range{0, 10'000});
}

/// Either corner may be left out: no bound.
void layout(auto& io, Is<Box> auto& x) {
  io.optional("min", x.min_mm, kPoint);
  io.optional("max", x.max_mm, kPoint);
}
void check(const auto& io, const Box& x) {
  if ((x.min_mm.array() >= x.max_mm.array()).any()) io.place().fail("expected every min below its max");
}

}  // namespace truepose::config
