#pragma once

#include <span>
#include <string>
#include <string_view>

namespace truepose::config {

/// ", did you mean 'x'?" for the known name nearest to a misspelt one, or nothing where none is near.
std::string suggestion(std::string_view misspelt, std::span<const std::string> known);

}  // namespace truepose::config
