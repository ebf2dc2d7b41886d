#include "proto/record/schema_io.hpp"

#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <utility>

namespace truepose::record {
namespace {

namespace json = boost::json;

json::string_view key_view(std::string_view text) { return {text.data(), text.size()}; }

/// A whole number without its ".0".
json::value bound(double number) {
  const auto whole = static_cast<std::int64_t>(number);
  return static_cast<double>(whole) == number ? json::value(whole) : json::value(number);
}

/// Describes the values that a layout would write. Each value under way is a schema of its own until it ends.
class SchemaIo final : public WriteIo {
 public:
  SchemaIo(Message message, Definitions& definitions)
      : is_request_{message == Message::Request}, definitions_{definitions} {}

  /// Of the whole value; a reference where that has a name.
  json::object schema() && {
    Open& whole = open_.front();
    return whole.name.empty() ? std::move(whole.schema) : defined(whole.name, std::move(whole.schema));
  }

  /// Members that stand behind a condition may be left out.
  bool has(std::string_view, bool) const override {
    open_.back().conditional = true;
    return true;
  }

  Io& about(std::string_view text) override {
    description_ = text;
    return *this;
  }
  Io& format(std::string_view format) override {
    format_ = format;
    return *this;
  }
  Io& refers(std::string_view name) override {
    refers_to_ = name;
    return *this;
  }
  void record(std::string_view name, std::string_view description) override {
    open_.back().name = name;
    open_.back().record_description = description;
  }
  void further_members() override { open_.back().is_open = true; }

 private:
  struct Open {
    std::string key;  ///< in the record around it
    bool is_required = false;
    bool is_nullable = false;
    std::string name, record_description;  ///< among the definitions
    bool is_open = false;
    mutable bool conditional = false;  ///< members may be left out
    bool shows_usual = false;          ///< the value is what holds where it is left out
    /// Of the value, said in the record around it.
    std::string description, format, refers_to;
    json::object schema, properties;
    json::array required;
  };

  bool enter(Presence presence, std::string_view key, bool) override {
    const bool is_there = is_request_ ? presence == Presence::Required : presence != Presence::Optional;
    const bool always = is_there && !open_.back().conditional;
    Open member{
        .key = std::string{key}, .is_required = always, .is_nullable = presence == Presence::Nullable};
    member.description = std::exchange(description_, {});
    member.format = std::exchange(format_, {});
    member.refers_to = std::exchange(refers_to_, {});
    member.shows_usual = is_request_ && presence == Presence::Defaulted;
    open_.push_back(std::move(member));
    return true;
  }
  void leave() override {
    Open done = std::move(open_.back());
    open_.pop_back();
    json::object schema = std::move(done.schema);
    if (!done.name.empty()) schema = defined(done.name, std::move(schema));
    if (!done.refers_to.empty()) schema = {{"$ref", definitions_.place + done.refers_to}};
    if (!done.format.empty()) schema["format"] = done.format;
    if (done.is_nullable) schema = or_null(std::move(schema));
    if (!done.description.empty()) {
      json::object described{{"description", done.description}};
      for (auto& [name, value] : schema) described[name] = std::move(value);
      schema = std::move(described);
    }
    Open& around = open_.back();
    if (done.key.empty()) {
      around.schema[around.schema.at("type") == "array" ? "items" : "additionalProperties"] =
          std::move(schema);
      return;
    }
    if (done.is_required) around.required.emplace_back(done.key);
    around.properties[done.key] = std::move(schema);
  }
  void end_record() override {
    Open& record = open_.back();
    json::object schema;
    if (!record.record_description.empty()) schema["description"] = record.record_description;
    schema["type"] = "object";
    if (!record.required.empty()) schema["required"] = std::move(record.required);
    schema["properties"] = std::move(record.properties);
    if (!record.is_open && !definitions_.may_grow) schema["additionalProperties"] = false;
    record.schema = std::move(schema);
  }
  std::size_t begin_list(std::size_t) override {
    open_.back().schema = {{"type", "array"}};
    return 0;
  }
  void enter_element(std::size_t) override { open_.emplace_back(); }
  std::size_t begin_members(std::size_t) override {
    open_.back().schema = {{"type", "object"}};
    return 0;
  }

  void number(double& x, Range range) override {
    json::object& schema = open_.back().schema = {{"type", "number"}};
    if (range.min > kAny.min) schema["minimum"] = bound(range.min);
    if (range.max < kAny.max) schema["maximum"] = bound(range.max);
    show_usual(bound(x));
  }
  void whole(std::int64_t& x, Whole range) override {
    constexpr Whole kEvery;
    json::object& schema = open_.back().schema = {{"type", "integer"}};
    if (range.min == range.max) schema["const"] = range.min;
    if (range.min == range.max) return;
    if (range.min > kEvery.min) schema["minimum"] = range.min;
    if (range.max < kEvery.max) schema["maximum"] = range.max;
    show_usual(x);
  }
  void seed(std::uint64_t& x) override {
    open_.back().schema = {{"type", "integer"}, {"minimum", 0}};
    show_usual(x);
  }
  void boolean(bool& x) override {
    open_.back().schema = {{"type", "boolean"}};
    show_usual(x);
  }
  void text(std::string&, bool) override { open_.back().schema = {{"type", "string"}}; }
  void file(std::filesystem::path&) override { open_.back().schema = {{"type", "string"}}; }
  void json(json::value&) override {}
  void json(json::object&) override { open_.back().schema = {{"type", "object"}}; }
  bool null_element(bool) override {
    open_.back().is_nullable = true;
    return false;
  }

  bool describes() const override { return true; }
  void describe_words(const std::vector<std::string_view>& words) override {
    json::array names;
    for (const std::string_view word : words) names.emplace_back(key_view(word));
    open_.back().schema = {{"type", "string"}, {"enum", std::move(names)}};
  }
  void describe_size(Size size) override {
    constexpr Size kAnySize;
    json::object& schema = open_.back().schema;
    const bool is_list = schema.at("type") == "array";
    if (size.min > kAnySize.min) schema[is_list ? "minItems" : "minLength"] = size.min;
    if (size.max < kAnySize.max) schema[is_list ? "maxItems" : "maxLength"] = size.max;
  }

  json::object defined(const std::string& name, json::object schema) {
    definitions_.schemas.emplace(key_view(name), std::move(schema));
    return {{"$ref", definitions_.place + name}};
  }
  static json::object or_null(json::object schema) {
    json::value* const type = schema.if_contains("type");
    if (!type) return {{"oneOf", json::array{std::move(schema), json::object{{"type", "null"}}}}};
    *type = json::array{*type, "null"};
    if (json::value* const words = schema.if_contains("enum")) words->as_array().emplace_back(nullptr);
    return schema;
  }
  void show_usual(json::value usual) {
    if (open_.back().shows_usual) open_.back().schema["default"] = std::move(usual);
  }

  std::vector<Open> open_ = std::vector<Open>(1);
  std::string description_, format_, refers_to_;
  bool is_request_;
  Definitions& definitions_;
};

}  // namespace

json::object described_schema(const std::function<void(Io&)>& layout, Message message,
                              Definitions& definitions) {
  SchemaIo io{message, definitions};
  layout(io);
  return std::move(io).schema();
}

}  // namespace truepose::record
