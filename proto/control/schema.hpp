#pragma once

#include <boost/json/value.hpp>
#include <string_view>

namespace truepose::control {

/// Text of openrpc.json, as it was when this program was built.
std::string_view openrpc_text();
/// The same without what is for people alone, descriptions and examples, so that it fits into a line.
const boost::json::value& openrpc_outline();
/// A method of it, with all that stands there; null where it has none of that name.
const boost::json::value* openrpc_method(std::string_view name);

}  // namespace truepose::control
