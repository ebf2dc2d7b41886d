#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <set>
#include <string>
#include <thread>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "daemon/cell/daemon_cell.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/schema_check.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::IsEmpty;

json::value schema() {
  const std::string_view text = control::openrpc_text();
  return json::parse({text.data(), text.size()});
}

TEST(TheControlProtocol, HasExactlyTheMethodsOfItsSchema) {
  std::vector<std::string> served = daemon::DaemonCell::method_names();
  for (const char* own :
       {"session.challenge", "session.hello", "session.ping", "system.info", "events.subscribe",
        "events.unsubscribe", "job.get", "control.get", "control.acquire", "control.takeover",
        "control.release", "audit.list", "audit.acknowledge"})
    served.emplace_back(own);
  EXPECT_THAT(served, testing::UnorderedElementsAreArray(rpc::method_names()));
}

TEST(TheControlProtocol, RefusesAParameterThatItDoesNotKnowInEveryMethod) {
  LiveCell cell;
  cell.start_daemon();
  tools::RpcClient client = cell.client();
  for (const std::string& method : rpc::method_names()) {
    const auto result = client.call(method, {{"nonsense", 1}});
    ASSERT_FALSE(result) << method;
    const bool opens_it = method == "session.challenge" || method == "session.hello";
    const char* const code = opens_it ? "-32600" : "-32602";
    EXPECT_THAT(result.error().message, testing::HasSubstr(code)) << method;
  }
}

/// A CellLink that greets with any text, and then listens.
class RudeController {
 public:
  explicit RudeController(std::string greeting)
      : thread_{[this, text = std::move(greeting)] {
          boost::system::error_code gone;
          tcp::socket client{context_};
          acceptor_.accept(client, gone);
          boost::asio::write(client, boost::asio::buffer(text), gone);
          for (std::array<char, 4096> buffer; !gone;) client.read_some(boost::asio::buffer(buffer), gone);
        }} {}
  ~RudeController() {
    ::shutdown(acceptor_.native_handle(), SHUT_RDWR);
    thread_.join();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  using tcp = boost::asio::ip::tcp;
  boost::asio::io_context context_;
  tcp::acceptor acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  std::thread thread_;
};

TEST(TheControlProtocol, AnswersWhateverAControllerSaysOfItself) {
  RudeController controller{"<Hello Ver=\"1\" Model=\"#KR210R2700_2 C4 FLR\" Serial=\"" +
                            std::string(60'000, 'S') + "\" Tool=\"0\" Base=\"0\" KssVer=\"KSS\"></Hello>"};
  LiveCell cell;
  std::string file = text_of(cell.cell_file());
  const std::string key = "eki_motion: 127.0.0.1:";
  const std::size_t port = file.find(key) + key.size();
  file.replace(port, file.find(' ', port) - port, std::to_string(controller.port()));
  cell.write("cell.yaml", file);
  cell.start_daemon();
  tools::RpcClient client = cell.client();
  ASSERT_TRUE(client.call("cell.connect", {}));
  const auto status = client.call("cell.status", {});
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_EQ(status->at_pointer("/robot/serial").as_string(), std::string(200, 'S'));
}

const Eigen::Vector3d kTcp_mm{0, 0, 300};

/// That the real arm's TCP is at these joints where the nominal one's is with the wrist stretched.
void expect_tcp_kept(tools::RpcClient& client, const json::value& joints) {
  const RobotModel nominal = config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml");
  const auto exported = client.call("model.export", {});
  ASSERT_TRUE(exported) << exported.error().message;
  const RobotModel real =
      config::parse_model(exported->at("yaml").as_string().c_str(), "exported").cell.robot;
  JointVector asked(6), q(6);
  asked << 0, -90, 90, 0, 0, 0;
  for (std::size_t i = 0; i < 6; ++i) q[static_cast<Eigen::Index>(i)] = joints.at(i).to_number<double>();
  const auto tcp_mm = [](const RobotModel& arm, const JointVector& deg) -> Eigen::Vector3d {
    return forward_kinematics(arm, deg * kRadPerDeg) * kTcp_mm;
  };
  EXPECT_LT((tcp_mm(real, q) - tcp_mm(nominal, asked)).norm(), 1e-5);
}

/// Of targets.compensate: a wrist stretched and nearly so, and a joint beyond its limit.
void expect_compensated(tools::RpcClient& client) {
  const auto of = [&](const json::array& joints) {
    return client.call("targets.compensate", {{"joints", json::array(1, joints)}});
  };
  const auto stretched = of({0, -90, 90, 0, 0, 0});
  ASSERT_TRUE(stretched) << stretched.error().message;
  EXPECT_TRUE(stretched->at("damped").at(0).as_bool());
  EXPECT_LT(stretched->at("residual_mm").at(0).to_number<double>(), 1e-6);
  expect_tcp_kept(client, stretched->at("joints").at(0));
  const auto bent = of({0, -90, 90, 0, 10, 0});  // enough for this cell's stream.singularity_threshold_deg
  ASSERT_TRUE(bent) << bent.error().message;
  EXPECT_FALSE(bent->at("damped").at(0).as_bool());
  const auto beyond = of({0, -90, 90, 0, 35, 360});
  ASSERT_FALSE(beyond);
  EXPECT_THAT(beyond.error().message, testing::HasSubstr("params.joints[0]: joint 6 would have to go to"));
}

/// That the daemon and the command line lead the arm to the same flange poses by the same joints.
void expect_joints_of_the_command_line(const LiveCell& cell, tools::RpcClient& client) {
  const json::array poses{json::array{1700, 0, 1500, 0, 60, 0}, json::array{1500, 800, 1200, 20, 70, 30},
                          json::array{-1300, 900, 1700, 140, 100, 10}};
  std::string rows = "x,y,z,a,b,c\n";
  for (const json::value& pose : poses) {
    const std::string row = json::serialize(pose);
    rows += row.substr(1, row.size() - 2) + "\n";
  }
  const auto online = client.call("targets.compensate", {{"poses", poses}});
  ASSERT_TRUE(online) << online.error().message;
  const auto exported = client.call("model.export", {});
  ASSERT_TRUE(exported) << exported.error().message;
  const Finished offline = run_program(
      "truepose", {"compensate", "--robot", TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml",
                   "--model", cell.write("exported.yaml", exported->at("yaml").as_string().c_str()),
                   "--poses", cell.write("poses.csv", rows), "--singularity-threshold", "5", "--json"});
  ASSERT_EQ(offline.exit_code, 0) << offline.err;
  const json::value document = json::parse(offline.out);
  for (std::size_t row = 0; row < poses.size(); ++row) {
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(online->at("joints").at(row).at(i).to_number<double>(),
                  document.at("joints").at(row).at(i).to_number<double>(), 1e-6)
          << "pose " << row << ", A" << i + 1;
  }
}

TEST(TheControlProtocol, AnswersAndTellsWhatItsSchemaSays) {
  LiveCell cell{{.speedup = 1000,
                 .cell = {{"singularity_threshold_deg: 20 ",
                           "singularity_threshold_deg: 5\n  tcp: {x: 0, y: 0, z: 300} "}}}};
  cell.start_daemon();
  const json::value document = schema();
  const SchemaCheck check{document};
  tools::RpcClient client = cell.client();
  const auto expect_fits = [&](const std::string& method, const json::object& params = {}) {
    const auto result = client.call(method, params);
    ASSERT_TRUE(result) << method << ": " << result.error().message;
    EXPECT_THAT(check.of_result(method, *result), IsEmpty()) << method;
  };
  for (const char* method : {"system.info", "system.config", "cell.status", "campaign.list", "model.list",
                             "stream.status", "recording.save", "recording.list", "events.subscribe"})
    expect_fits(method);

  const Finished campaign = small_campaign(cell);
  ASSERT_EQ(campaign.exit_code, 0) << campaign.err << cell.daemon().errors();
  for (const char* method : {"cell.status", "campaign.list", "model.list", "model.get", "model.export",
                             "stream.status", "report.get"})
    expect_fits(method);
  expect_fits("campaign.get", {{"points_limit", 100}});
  expect_fits("targets.compensate", {{"joints", json::array(1, {0, -90, 90, 0, 35, 0})}});
  expect_fits("targets.compensate", {{"poses", json::array(1, {1700, 0, 1500, 0, 60, 0})}});
  expect_compensated(client);
  expect_joints_of_the_command_line(cell, client);
  for (const char* kind : {"targets", "iso9283"}) {
    std::vector<std::string> start{"campaign", "start", "--kind", kind, "--watch"};
    const bool cycles = start[3] == "iso9283";
    start.insert(start.end(), {cycles ? "--cycles" : "--validate", "2"});
    const Finished run = cell.truepose(start);
    ASSERT_EQ(run.exit_code, 0) << run.err << cell.daemon().errors();
    expect_fits("campaign.get");
    expect_fits("campaign.get", {{"points_limit", 50}});
  }
  const Finished tool = cell.truepose({"campaign", "start", "--tool", "3", "--tool-poses", "4", "--watch"});
  ASSERT_EQ(tool.exit_code, 0) << tool.err << cell.daemon().errors();
  expect_fits("campaign.get");
  expect_fits("campaign.get", {{"points_limit", 50}});
  const auto measured = client.call("campaign.get", {});
  expect_fits("tool.activate", {{"id", measured->at_pointer("/campaign/id")}});
  expect_fits("tool.list");
  expect_fits("tool.deactivate", {{"number", 3}});
  expect_fits("campaign.list");
  for (const char* method :
       {"stream.start", "cell.status", "stream.stop", "cell.disconnect", "model.deactivate", "cell.connect"})
    expect_fits(method);

  std::set<std::string> topics;
  while (!topics.contains("campaign") || !topics.contains("stream")) {
    const auto event = client.next_event();
    ASSERT_TRUE(event) << event.error().message;
    EXPECT_THAT(check.of_event(event->topic, event->data), IsEmpty()) << event->topic;
    topics.insert(event->topic);
  }
  EXPECT_TRUE(topics.contains("measurement"));
  EXPECT_TRUE(topics.contains("cell"));
}

TEST(TheCheckOfSchemas, SeesWhatDoesNotFit) {
  const json::value document = schema();
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
