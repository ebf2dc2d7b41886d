#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <string>
#include <utility>

#include "proto/record/io.hpp"

namespace truepose::record {

/// Who writes the value that is described.
enum class Message {
  Answer,   ///< a text of ours: what has a usual value is always there
  Request,  ///< a text that is sent to us: what has a usual value may be left out
};

/// Schemas of named records, which others refer to.
struct Definitions {
  std::string place = "#/$defs/";
  bool may_grow = false;  ///< readers pass over members that they do not know
  boost::json::object schemas{};
};

/// @param definitions  gets the records that have a name
boost::json::object described_schema(const std::function<void(Io&)>& layout, Message message,
                                     Definitions& definitions);

/// The JSON Schema of a record's documents (draft 2020-12), by its layout. Records that have a name stand
/// once in "$defs".
template <class Record>
boost::json::object schema_of() {
  Record x{};
  Definitions definitions;
  boost::json::object schema = described_schema([&](Io& io) { io.value(x); }, Message::Answer, definitions);
  if (!definitions.schemas.empty()) schema["$defs"] = std::move(definitions.schemas);
  return schema;
}

}  // namespace truepose::record
