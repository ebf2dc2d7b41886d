#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// All methods, as openrpc.json lists them.
const std::vector<Described>& methods();
/// One of them by its name; null where there is none.
const Method* method_named(std::string_view name);
/// Their names, sorted.
std::vector<std::string> method_names();

/// The document of the protocol with methods, events and schemas as the records have them.
/// @param document  openrpc.json: what is kept of it is the protocol's description, the errors, the examples
///     of the methods, the summaries of the events, and the schemas that no record has
boost::json::object described_protocol(boost::json::object document);

}  // namespace truepose::rpc
