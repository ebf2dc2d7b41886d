#pragma once

#include <boost/json/value.hpp>
#include <string>
#include <vector>

namespace truepose {

/// Checks values against the schemas of openrpc.json, with as much of JSON Schema as those use.
class SchemaCheck {
 public:
  /// @param document  openrpc.json; outlives the check
  explicit SchemaCheck(const boost::json::value& document) : document_{document} {}

  /// What is wrong with a method's result, "/stream/state: ..." each; empty where all is right.
  std::vector<std::string> of_result(const std::string& method, const boost::json::value& result) const;
  /// What is wrong with an event's data.
  std::vector<std::string> of_event(const std::string& topic, const boost::json::value& data) const;
  std::vector<std::string> of(const boost::json::value& schema, const boost::json::value& value) const {
    return of(document_, schema, value, "");
  }

 private:
  /// @param home  the file that the schema's references without a file are to
  std::vector<std::string> of(const boost::json::value& home, const boost::json::value& schema,
                              const boost::json::value& value, const std::string& where) const;

  const boost::json::value& document_;
};

}  // namespace truepose
