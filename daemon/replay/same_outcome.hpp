#pragma once

#include <string_view>

namespace truepose::daemon {

/// Whether two outcomes say the same, but for the last digits of numbers, in which the mathematical functions
/// of two machines may differ.
bool same_outcome(std::string_view recorded, std::string_view now);

}  // namespace truepose::daemon
