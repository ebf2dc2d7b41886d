// What the cell's methods do with parameters that are none: openrpc.json says which are.
#include <boost/json/serialize.hpp>
#include <string>

#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;

const json::array& described_methods() {
  static const json::value document = control::parse_json(control::openrpc_text()).value();
  return document.at("methods").as_array();
}

/// Those of a method's first example, without what the server takes before the cell is asked.
json::object example_params(const json::value& method) {
  json::object params;
  for (const json::value& param : method.at_pointer("/examples/0/params").as_array())
    params[param.at("name").as_string()] = param.at("value");
  params.erase("command_id");
  params.erase("job");
  return params;
}

bool fits(const json::value& schema, const json::value& value) {
  const json::value* const format = schema.as_object().if_contains("format");
  if (format && *format == "uuid" && value == "") return false;
  return CellTest::promises().of(schema, value).empty();
}

using Parameters = CellTest;

TEST_F(Parameters, OfAnotherTypeOrValueThanPromisedAreRefusedByNameInEveryMethod) {
  load();
  const std::vector<std::string> served = DaemonCell::method_names();
  const json::array anything{nullptr, json::object{}, json::array{}, 5, true, -1e15, "", "text"};
  int refusals = 0;
  for (const json::value& method : described_methods()) {
    const std::string name{method.at("name").as_string()};
    if (std::ranges::find(served, name) == served.end()) continue;
    for (const json::value& param : method.at("params").as_array()) {
      const std::string key{param.at("name").as_string()};
      if (key == "command_id" || key == "job") continue;
      for (const json::value& value : anything) {
        if (fits(param.at("schema"), value)) continue;
        SCOPED_TRACE(name + " " + key + " " + json::serialize(value));
        json::object params = example_params(method);
        params[key] = value;
        const Answer answer = call(name, params);
        ASSERT_FALSE(answer) << json::serialize(*answer);
        EXPECT_EQ(answer.error().code, control::ErrorCode::InvalidParams) << answer.error().message;
        EXPECT_THAT(answer.error().path, testing::StartsWith("params." + key)) << answer.error().message;
        ++refusals;
      }
    }
  }
  EXPECT_GT(refusals, 300);
}

TEST_F(Parameters, ANoteIsKeptWholeOrRefusedByItsCharacters) {
  load();
  std::string umlauts;
  for (int i = 0; i < 500; ++i) umlauts += "ü";
  EXPECT_THAT(refused("campaign.start", {{"note", umlauts + "."}}),
              testing::HasSubstr("params.note: expected at most 500 characters, found 501"));
  EXPECT_THAT(refused("drift.check", {{"note", umlauts + "."}}), testing::HasSubstr("params.note"));
  play([&]() -> Wait {
    json::object params{{"note", umlauts}};
    const Answer started = co_await ask("campaign.start", params);
    EXPECT_TRUE(started) << started.error().message;
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_TRUE(aborted) << aborted.error().message;
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/note").as_string(), umlauts);
}

}  // namespace
}  // namespace truepose::daemon
