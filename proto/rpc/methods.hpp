#pragma once

#include <boost/json/object.hpp>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// All methods, as openrpc.json lists them.
const std::vector<Described>& methods();

/// The document of the protocol with methods, events and schemas as the records have them.
/// @param document  openrpc.json: what is kept of it is the protocol's description, the errors, the examples
///     of the methods, the summaries of the events, and the schemas that no record has
boost::json::object described_protocol(boost::json::object document);

}  // namespace truepose::rpc
