#include "proto/control/schema.hpp"

#include <algorithm>
#include <boost/json/parse.hpp>

namespace truepose::control {

std::vector<std::string> schema_methods() {
  const std::string_view text = openrpc_text();
  const boost::json::value schema = boost::json::parse({text.data(), text.size()});
  std::vector<std::string> names;
  for (const auto& method : schema.at("methods").as_array()) {
    const auto& name = method.at("name").as_string();
    names.emplace_back(name.data(), name.size());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace truepose::control
