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
  json::object schema() && {
    json::object whole = std::move(open_.front().schema);
    if (!definitions_.empty()) whole["$defs"] = std::move(definitions_);
    return whole;
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
    std::string description, format;   ///< of the value, said in the record around it
    json::object schema, properties;
    json::array required;
  };

  bool enter(Presence presence, std::string_view key, bool) override {
    const bool always = presence != Presence::Optional && !open_.back().conditional;
    Open member{
        .key = std::string{key}, .is_required = always, .is_nullable = presence == Presence::Nullable};
    member.description = std::exchange(description_, {});
    member.format = std::exchange(format_, {});
    open_.push_back(std::move(member));
    return true;
  }
  void leave() override {
    Open done = std::move(open_.back());
    open_.pop_back();
    json::object schema = std::move(done.schema);
    if (!done.name.empty()) {
      definitions_.emplace(key_view(done.name), std::move(schema));
      schema = {{"$ref", "#/$defs/" + done.name}};
    }
    if (!done.format.empty()) schema["format"] = done.format;
    if (done.is_nullable)
      schema = {{"oneOf", json::array{std::move(schema), json::object{{"type", "null"}}}}};
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
    if (!record.is_open) schema["additionalProperties"] = false;
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

  void number(double&, Range range) override {
    json::object& schema = open_.back().schema = {{"type", "number"}};
    if (range.min > kAny.min) schema["minimum"] = bound(range.min);
    if (range.max < kAny.max) schema["maximum"] = bound(range.max);
  }
  void whole(std::int64_t&, Whole range) override {
    constexpr Whole kEvery;
    json::object& schema = open_.back().schema = {{"type", "integer"}};
    if (range.min > kEvery.min) schema["minimum"] = range.min;
    if (range.max < kEvery.max) schema["maximum"] = range.max;
  }
  void seed(std::uint64_t&) override { open_.back().schema = {{"type", "integer"}, {"minimum", 0}}; }
  void boolean(bool&) override { open_.back().schema = {{"type", "boolean"}}; }
  void text(std::string&, bool) override { open_.back().schema = {{"type", "string"}}; }
  void file(std::filesystem::path&) override { open_.back().schema = {{"type", "string"}}; }

  bool describes() const override { return true; }
  void describe_words(const std::vector<std::string_view>& words) override {
    json::array names;
    for (const std::string_view word : words) names.emplace_back(key_view(word));
    open_.back().schema = {{"enum", std::move(names)}};
  }
  void describe_size(std::size_t least, std::size_t most) override {
    open_.back().schema["minItems"] = least;
    open_.back().schema["maxItems"] = most;
  }

  std::vector<Open> open_ = std::vector<Open>(1);
  json::object definitions_;
  std::string description_, format_;
};

}  // namespace

json::object described_schema(const std::function<void(Io&)>& layout) {
  SchemaIo io;
  layout(io);
  return std::move(io).schema();
}

}  // namespace truepose::record
