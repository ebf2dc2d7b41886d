#pragma once

#include <string>

namespace truepose {

/// The text of a measurement file with all rows marked to identify.
inline std::string unmarked(std::string measurements) {
  const std::string validate = "validate";
  for (std::size_t at; (at = measurements.find(validate)) != std::string::npos;)
    measurements.replace(at, validate.size(), "identify");
  return measurements;
}

}  // namespace truepose
