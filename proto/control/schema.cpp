#include "proto/control/schema.hpp"

#include <boost/json/parse.hpp>

namespace truepose::control {

namespace {

const boost::json::value& document() {
  static const boost::json::value kDocument = [] {
    const std::string_view text = openrpc_text();
    return boost::json::parse({text.data(), text.size()});
  }();
  return kDocument;
}

boost::json::value outline_of(const boost::json::value& part) {
  if (const auto* list = part.if_array()) {
    boost::json::array all;
    for (const boost::json::value& one : *list) all.push_back(outline_of(one));
    return all;
  }
  const auto* const object = part.if_object();
  if (!object) return part;
  boost::json::object left;
  for (const auto& [key, value] : *object) {
    const bool for_people = (key == "description" && value.is_string()) || key == "examples";
    if (!for_people) left[key] = outline_of(value);
  }
  return left;
}

}  // namespace

const boost::json::value& openrpc_outline() {
  static const boost::json::value kOutline = outline_of(document());
  return kOutline;
}

const boost::json::value* openrpc_method(std::string_view name) {
  for (const auto& method : document().at("methods").as_array())
    if (method.at("name").as_string() == boost::json::string_view{name.data(), name.size()}) return &method;
  return nullptr;
}

}  // namespace truepose::control
