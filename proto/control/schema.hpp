#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace truepose::control {

/// Text of openrpc.json, as it was when this program was built.
std::string_view openrpc_text();
/// Names of the methods in it, sorted.
std::vector<std::string> schema_methods();

}  // namespace truepose::control
