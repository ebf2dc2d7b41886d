#pragma once

#include <stdexcept>
#include <string>

namespace truepose::config {

/// A file that cannot be used. what() is the one line for the operator: "cell.yaml:12:9: tracker.port:
/// expected 1..65535, found 99999", or "poses.csv: row 7: q3: not a number: 'abc'".
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace truepose::config
