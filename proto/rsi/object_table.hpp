#pragma once

#include <string_view>

namespace truepose::rsi {

/// The text of objects.tsv.
std::string_view object_table();

}  // namespace truepose::rsi
