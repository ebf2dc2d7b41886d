#include "tests/schema_check.hpp"

#include <algorithm>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <map>

#include "config/text_file.hpp"

namespace truepose {
namespace json = boost::json;
namespace {

bool is_of_type(const json::value& value, std::string_view type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_bool();
  if (type == "null") return value.is_null();
  if (type == "integer") return value.is_int64() || value.is_uint64();
  if (type == "number") return value.is_number();
  throw std::runtime_error{"a schema has an unknown type: " + std::string{type}};
}

bool is_of_types(const json::value& value, const json::value& types) {
  if (types.is_string()) return is_of_type(value, types.get_string());
  return std::ranges::any_of(types.as_array(),
                             [&](const json::value& type) { return is_of_type(value, type.as_string()); });
}

const json::value& named(const json::array& list, const char* key, const std::string& name) {
  const auto found =
      std::ranges::find_if(list, [&](const json::value& one) { return one.at(key).as_string() == name; });
  if (found == list.end()) throw std::runtime_error{"openrpc.json has no " + name};
  return *found;
}

/// A schema in the folder of openrpc.json.
const json::value& sibling_schema(const std::string& name) {
  static std::map<std::string, json::value> files;
  const auto [file, is_new] = files.try_emplace(name);
  if (is_new)
    file->second = json::parse(config::read_text_file(TRUEPOSE_SOURCE_DIR "/proto/control/" + name));
  return file->second;
}

}  // namespace

std::vector<std::string> SchemaCheck::of_result(const std::string& method, const json::value& result) const {
  return of(named(document_.at("methods").as_array(), "name", method).at("result").at("schema"), result);
}

std::vector<std::string> SchemaCheck::of_event(const std::string& topic, const json::value& data) const {
  return of(named(document_.at("x-events").as_array(), "topic", topic).at("data"), data);
}

std::vector<std::string> SchemaCheck::of(const json::value& home, const json::value& schema,
                                         const json::value& value, const std::string& where) const {
  const json::object& rules = schema.as_object();
  const auto rule = [&rules](const char* name) { return rules.if_contains(name); };
  if (const json::value* reference = rule("$ref")) {
    const std::string text{reference->as_string()};
    const std::size_t pointer = text.find('#');
    const json::value& other = pointer == 0 ? home : sibling_schema(text.substr(0, pointer));
    return of(other, pointer == std::string::npos ? other : other.at_pointer(text.substr(pointer + 1)), value,
              where);
  }

  std::vector<std::string> wrong;
  const auto fail = [&](const std::string& why) {
    wrong.push_back(where + ": " + why + ", found " + json::serialize(value).substr(0, 80));
  };
  const auto descend = [&](const json::value& inner, const json::value& part, const std::string& name) {
    for (std::string& line : of(home, inner, part, where + "/" + name)) wrong.push_back(std::move(line));
  };

  if (const json::value* types = rule("type"); types && !is_of_types(value, *types)) {
    fail("expected " + json::serialize(*types));
    return wrong;
  }
  if (const json::value* only = rule("const"); only && value != *only)
    fail("expected " + json::serialize(*only));
  if (const json::value* list = rule("enum"); list && !std::ranges::count(list->as_array(), value))
    fail("expected one of " + json::serialize(*list));
  if (const json::value* choices = rule("oneOf")) {
    const auto fits = std::ranges::count_if(choices->as_array(), [&](const json::value& choice) {
      return of(home, choice, value, where).empty();
    });
    if (fits != 1) fail("expected exactly one of " + json::serialize(*choices));
  }
  if (const json::object* object = value.if_object()) {
    if (const json::value* required = rule("required")) {
      for (const json::value& name : required->as_array()) {
        if (!object->contains(name.as_string())) fail("expected the member " + json::serialize(name));
      }
    }
    const json::value *properties = rule("properties"), *others = rule("additionalProperties");
    for (const auto& [name, part] : *object) {
      const json::value* const inner = properties ? properties->as_object().if_contains(name) : nullptr;
      if (inner) {
        descend(*inner, part, name);
      } else if (others && others->is_object()) {
        descend(*others, part, name);
      } else if (properties) {
        // Clients pass over what they do not know; the schema is to name all there is nevertheless.
        fail("the schema does not name " + std::string{name});
      }
    }
  }
  if (const json::array* array = value.if_array()) {
    const json::value *least = rule("minItems"), *most = rule("maxItems");
    const auto size = static_cast<std::int64_t>(array->size());
    if ((least && size < least->as_int64()) || (most && size > most->as_int64()))
      fail("expected another length");
    if (const json::value* items = rule("items")) {
      for (std::size_t i = 0; i < array->size(); ++i) descend(*items, (*array)[i], std::to_string(i));
    }
  }
  if (value.is_number()) {
    const json::value *least = rule("minimum"), *most = rule("maximum");
    const double number = value.to_number<double>();
    if ((least && number < least->to_number<double>()) || (most && number > most->to_number<double>()))
      fail("expected another range");
  }
  return wrong;
}

}  // namespace truepose
