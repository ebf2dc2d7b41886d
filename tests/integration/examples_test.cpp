// The examples of openrpc.json, run against the daemon in the order in which a panel comes to them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <map>
#include <set>
#include <string>

#include "daemon/control/audit_files.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"
#include "tests/await.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/schema_check.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::IsEmpty;

/// A client that knows nothing of ours but the socket.
class LineClient {
 public:
  explicit LineClient(std::uint16_t port) {
    socket_.connect({boost::asio::ip::address_v4::loopback(), port});
  }

  /// The whole answer. What comes unasked is passed over.
  json::object ask(const std::string& method, const json::object& params) {
    const json::object request{{"jsonrpc", "2.0"}, {"id", ++id_}, {"method", method}, {"params", params}};
    boost::asio::write(socket_, boost::asio::buffer(json::serialize(request) + "\n"));
    while (true) {
      const std::size_t size = boost::asio::read_until(socket_, boost::asio::dynamic_buffer(buffer_), '\n');
      json::object answer = json::parse(buffer_.substr(0, size)).as_object();
      buffer_.erase(0, size);
      if (answer.contains("id")) return answer;
    }
  }

 private:
  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_{context_};
  std::string buffer_;
  std::int64_t id_ = 0;
};

/// Whether a text is a name that the daemon gives: a UUID, the number of a job, the name of a recording.
bool is_given_name(std::string_view text) {
  const bool digits = text.find_first_not_of("0123456789abcdef-") == std::string_view::npos;
  return (digits && (text.size() == 36 || text.size() == 16)) || text.ends_with(".pcapng");
}

class Examples : public testing::Test {
 protected:
  /// Runs a method's examples, with the names of this run in place of those in them.
  void run(const std::string& method) {
    const json::value* const described = control::openrpc_method(method);
    ASSERT_TRUE(described) << method;
    run_.insert(method);
    for (const json::value& example : described->at("examples").as_array()) {
      SCOPED_TRACE(method + ", " + std::string{example.at("name").as_string()});
      json::object params;
      for (const json::value& param : example.at("params").as_array())
        params[param.at("name").as_string()] = named_now(param.at("value"));
      const json::object answer = client_.ask(method, params);
      const json::value* const result = answer.if_contains("result");
      ASSERT_TRUE(result) << json::serialize(answer);
      const json::value& shown = example.at("result").at("value");
      if (params.contains("job")) {
        EXPECT_TRUE(result->at("job").is_string());
      } else {
        EXPECT_THAT(check_.of_result(method, *result), IsEmpty());
      }
      learn_names(shown, *result);
    }
  }
  void run_all(std::initializer_list<const char*> methods) {
    for (const char* method : methods) {
      if (HasFatalFailure()) return;
      run(method);
    }
  }
  json::value status() { return client_.ask("cell.status", {}).at("result"); }
  void wait_for(std::string_view state) {
    await(
        "the cell's state is " + std::string{state},
        [&] { return status().at("state").as_string() == state; },
        [&] {
          return json::serialize(status()) + json::serialize(cell_.steer({{"ask", "program"}}));
        });
  }

  /// @param shown  the campaign's id in the examples
  void measure_tool(const std::string& shown) {
    const json::object started =
        client_.ask("campaign.start", {{"kind", "tool"}, {"number", 3}, {"poses_per_point", 4}});
    ASSERT_TRUE(started.contains("result")) << json::serialize(started);
    names_.insert_or_assign(shown, std::string{started.at("result").at("id").as_string()});
    wait_for("ready");
  }

  json::value named_now(const json::value& value) const {
    if (!value.is_string()) return value;
    const auto known = names_.find(std::string{value.get_string()});
    return known == names_.end() ? value : json::value(known->second);
  }
  void learn_names(const json::value& shown, const json::value& now) {
    if (shown.is_object() && now.is_object()) {
      for (const auto& [key, part] : shown.get_object()) {
        if (const json::value* same = now.get_object().if_contains(key)) learn_names(part, *same);
      }
    } else if (shown.is_array() && now.is_array()) {
      const std::size_t count = std::min(shown.get_array().size(), now.get_array().size());
      for (std::size_t i = 0; i < count; ++i) learn_names(shown.get_array()[i], now.get_array()[i]);
    } else if (shown.is_string() && now.is_string() && is_given_name(std::string{shown.get_string()})) {
      names_.insert_or_assign(std::string{shown.get_string()}, std::string{now.get_string()});
    }
  }

  const json::value document_ = json::parse(std::string{control::openrpc_text()});
  const SchemaCheck check_{document_};
  /// With its daemon.
  struct StartedCell : LiveCell {
    StartedCell() : LiveCell{{.patient = true}} { start_daemon(); }
  };
  StartedCell cell_;
  LineClient client_{cell_.control_port()};
  std::map<std::string, std::string> names_;
  std::set<std::string> run_;
};

TEST_F(Examples, AreAnsweredByTheDaemonAsTheSchemaSays) {
  run_all({"session.challenge", "session.hello", "session.ping", "system.info", "system.config",
           "control.get", "control.acquire", "control.takeover", "events.subscribe", "cell.status",
           "cell.connect", "campaign.start", "campaign.pause", "campaign.resume", "campaign.abort",
           "campaign.start"});
  wait_for("ready");
  run_all({"campaign.list", "campaign.get", "campaign.points", "report.get", "report.html", "job.get",
           "model.list", "model.get", "model.export", "model.activate", "model.deactivate", "model.rollback",
           "targets.compensate", "drift.check"});
  wait_for("ready");
  measure_tool("7f0d6a5e-31c4-4b0f-9d53-2c1a8e64b0f7");
  run_all({"tool.activate", "tool.list", "tool.deactivate"});
  run_all({"campaign.identify", "campaign.export", "store.backup", "store.get_backup"});
  run_all(
      {"stream.start", "stream.status", "stream.stop", "recording.save", "recording.list", "recording.get"});
  run_all({"cell.disconnect", "stream.arm", "stream.disarm", "cell.connect"});
  cell_.steer({{"kind", "eki-drop"}, {"lasts_ms", 6'000'000}});
  wait_for("fault");
  run_all({"cell.acknowledge", "audit.list", "events.unsubscribe", "control.release"});
  std::filesystem::remove(daemon::audit_file_of(cell_.store_file()));
  run_all({"audit.acknowledge"});
  EXPECT_THAT(run_, testing::UnorderedElementsAreArray(rpc::method_names()));
}

TEST(TheExamplesOfTheSchema, FitIt) {
  const json::value document = json::parse(std::string{control::openrpc_text()});
  const SchemaCheck check{document};
  for (const std::string& name : rpc::method_names()) {
    SCOPED_TRACE(name);
    const json::value& method = *control::openrpc_method(name);
    const json::value* const examples = method.as_object().if_contains("examples");
    ASSERT_TRUE(examples && !examples->as_array().empty());
    for (const json::value& example : examples->as_array()) {
      std::set<std::string> given;
      for (const json::value& param : example.at("params").as_array()) {
        given.emplace(param.at("name").as_string());
        const auto known = std::ranges::find_if(method.at("params").as_array(), [&](const json::value& one) {
          return one.at("name") == param.at("name");
        });
        ASSERT_NE(known, method.at("params").as_array().end()) << param.at("name");
        EXPECT_THAT(check.of(known->at("schema"), param.at("value")), IsEmpty()) << param.at("name");
      }
      for (const json::value& param : method.at("params").as_array()) {
        const json::value* const required = param.as_object().if_contains("required");
        if (!required || !required->as_bool()) continue;
        EXPECT_TRUE(given.contains(param.at("name").as_string().c_str()));
      }
      if (given.contains("job")) continue;
      EXPECT_THAT(check.of_result(name, example.at("result").at("value")), IsEmpty());
    }
  }
}

TEST(TheCheckOfSchemas, SeesWhatDoesNotFit) {
  const json::value document = json::parse(std::string{control::openrpc_text()});
  const SchemaCheck check{document};
  const json::value times = {{"$ref", "#/components/schemas/Percentiles"}};
  EXPECT_THAT(check.of(times, {{"p50", 1}, {"p99", 1.5}, {"p999", 2}, {"max", 3}}), IsEmpty());
  EXPECT_EQ(check.of(times, {{"p50", "1"}, {"p99", 1.5}, {"p999", 2}}).size(), 2u);
  const json::value choice =
      json::parse(R"({"oneOf": [{"type": "integer", "minimum": 0}, {"type": "null"}]})");
  EXPECT_THAT(check.of(choice, 0), IsEmpty());
  EXPECT_THAT(check.of(choice, nullptr), IsEmpty());
  EXPECT_EQ(check.of(choice, -1).size(), 1u);
  const json::value list = json::parse(R"({"type": "array", "minItems": 1, "items": {"enum": ["a", "b"]}})");
  EXPECT_THAT(check.of(list, {"a", "b"}), IsEmpty());
  EXPECT_EQ(check.of(list, {"a", "c"}).size(), 1u);
  EXPECT_EQ(check.of(list, json::array{}).size(), 1u);
}

}  // namespace
}  // namespace truepose
