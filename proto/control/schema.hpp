#pragma once

#include <boost/json/value.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/control/access.hpp"

namespace truepose::control {

/// Text of openrpc.json, as it was when this program was built.
std::string_view openrpc_text();
/// The same without what is for people alone, descriptions and examples, so that it fits into a line.
const boost::json::value& openrpc_outline();
/// A method of it, with all that stands there; null where it has none of that name.
const boost::json::value* openrpc_method(std::string_view name);
/// Names of the methods in it, sorted.
std::vector<std::string> schema_methods();
/// The least role that may call a method (its x-role); none of a method that the schema does not know.
std::optional<Role> role_of(std::string_view method);
/// Whether a method is carried out even where it cannot be put on record (its x-always): one that takes
/// motion or a correction away, or control.
bool is_always_carried_out(std::string_view method);

}  // namespace truepose::control
