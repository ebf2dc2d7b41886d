#pragma once

#include <functional>
#include <string>
#include <vector>

#include "config/yaml_reader.hpp"
#include "core/math/refraction.hpp"
#include "core/plan/scene.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/io.hpp"

/// Records in YAML by their layouts (proto/record/layout.hpp). One that is written reads back as exactly what
/// it was: every number has the digits that bring it back, a text stands in double quotes.
namespace truepose::config {

// A layout is made of the words of record, here and in every file that says one.
using namespace record;

std::string written_yaml(const std::function<void(Io&)>& write);
/// Throws ConfigError.
void read_yaml_value(const YamlValue& value, const std::function<void(Io&)>& read);

template <class Record>
std::string yaml_of(const Record& x) {
  // A layout changes a record only where it reads.
  return written_yaml([&](Io& io) { io.value(const_cast<Record&>(x)); });
}

/// Throws ConfigError.
template <class T, class... How>
void read_value(const YamlValue& value, T& x, const How&... how) {
  read_yaml_value(value, [&](Io& io) { io.value(x, how...); });
}

/// The value where a text of YAML is being read: for a form that reads by itself.
const YamlValue& yaml_value(const Io& io);

/// Numbers in rows that all have the same number of columns.
struct Rows {
  std::vector<int> columns;  ///< one of these

  std::vector<std::vector<double>> form_of(const Eigen::MatrixXd& A) const;
  void read(const Io& io, Eigen::MatrixXd& A) const;
};

}  // namespace truepose::config

/// What surrounds an arm and its tracker.
namespace truepose::record {

void layout(Io& io, Air& x);
void layout(Io& io, Capsule& x);
void layout(Io& io, Box& x);
void check(const Io& io, const Box& x);

}  // namespace truepose::record
