#pragma once

#include <string>
#include <string_view>

namespace truepose::recording {

/// Bytes of a record on one line: text as it is, what is none in hexadecimal digits.
std::string shown(std::string_view bytes);

}  // namespace truepose::recording
