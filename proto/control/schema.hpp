#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/control/access.hpp"

namespace truepose::control {

/// Text of openrpc.json, as it was when this program was built.
std::string_view openrpc_text();
/// Names of the methods in it, sorted.
std::vector<std::string> schema_methods();
/// The least role that may call a method (its x-role); none of a method that the schema does not know.
std::optional<Role> role_of(std::string_view method);

}  // namespace truepose::control
