#pragma once

#include <boost/json/object.hpp>
#include <functional>

#include "proto/record/io.hpp"

namespace truepose::record {

boost::json::object described_schema(const std::function<void(Io&)>& layout);

/// The JSON Schema of a record's documents (draft 2020-12), by its layout. Records that have a name stand
/// once in "$defs".
template <class Record>
boost::json::object schema_of() {
  Record x{};
  return described_schema([&](Io& io) { io.value(x); });
}

}  // namespace truepose::record
