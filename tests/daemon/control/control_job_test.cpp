// Greeting, heartbeat, and calls that continue by themselves.
#include <gmock/gmock.h>

#include "tests/daemon/control_fixture.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::Notification;
using testing::HasSubstr;

class ControlJobs : public ControlServerTest {
 protected:
  ControlJobs() {
    write_access({{control::entry_for_token("Anna", control::Role::Operator, "token of Anna, long"),
                   control::entry_for_token("Eve", control::Role::Admin, "token of Eve, long")}});
  }
  std::unique_ptr<Client> session(const std::string& name) {
    auto client = std::make_unique<Client>(server_->port());
    EXPECT_EQ(Client::code_of(client->hello("token of " + name + ", long")), 0);
    return client;
  }
  static std::string state(const json::value& job) { return job.at("state").as_string().c_str(); }
};

TEST_F(ControlServerTest, GreetsBeforeAnythingIsAsked) {
  Client client{serve()};
  const json::value greeting = client.greeting();
  EXPECT_EQ(greeting.at("method").as_string(), "greeting");
  const json::value& params = greeting.at("params");
  EXPECT_EQ(params.at("product").as_string(), "trueposed");
  EXPECT_EQ(params.at("protocol").at("major").as_int64(), 1);
  EXPECT_GE(params.at("protocol").at("minor").as_int64(), 1);
  EXPECT_EQ(params.at("cell").as_string(), "cell 1");
  EXPECT_EQ(params.at("time").as_string(), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(Client::code_of(client.hello()), 0);
}

TEST_F(ControlServerTest, ClosesAnIdleSessionThatGivesNoSignOfLife) {
  const auto port = serve();
  Client idle{port}, alive{port}, listener{port}, promised{port};
  for (Client* client : {&idle, &alive, &listener}) client->hello();
  promised.call("session.hello", {{"protocol", 1}, {"token", std::string{kToken}}, {"heartbeat_s", 30}});
  listener.call("events.subscribe");
  promised.call("events.subscribe");
  const auto ping = [&] { EXPECT_EQ(alive.code("session.ping"), 0); };
  EXPECT_GE(pass_until_open(3, ping), 30s) << "as it had named";
  EXPECT_THAT(promised.reply().result.error().message, HasSubstr("session.ping"));
  EXPECT_GE(pass_until_open(2, ping), 25s) << "60 s in all";
  EXPECT_THAT(idle.reply().result.error().message, HasSubstr("nothing was asked for too long"));
  EXPECT_EQ(alive.call("session.ping").result->at("next_seq").as_int64(), 1000);
  EXPECT_EQ(listener.code("session.ping"), 0);
}

TEST_F(ControlServerTest, TellsASlowReaderHowManyEventsItMissed) {
  Client client{serve(), 4096};
  client.hello();
  client.call("events.subscribe");
  const json::object data{{"text", std::string(60'000, 'x')}};
  // More than the kernel keeps for it, so that the server cannot write them away before the last is there.
  constexpr unsigned kLogs = 600;
  for (unsigned i = 0; i < kLogs; ++i) events_.publish(control::Topic::Log, data);
  events_.publish(control::Topic::Fault, json::object{{"code", "E_BEAM"}});
  std::uint64_t got = 0, dropped = 0;
  for (std::string topic; topic != "fault"; ++got) {
    const Event event = client.event();
    topic = event.topic;
    if (const json::value* logs = event.dropped.if_contains("log"))
      dropped += logs->to_number<std::uint64_t>();
  }
  EXPECT_EQ(got + dropped, kLogs + 1);
  EXPECT_GT(dropped, 0U);
  std::uint64_t counted = 0;
  on_loop([&] { counted = server_->load().dropped_events[control::Topic::Log]; });
  EXPECT_EQ(counted, dropped);
}

TEST_F(ControlJobs, AreAnsweredAtOnceAndLetTheConnectionGoOn) {
  serve();
  const auto anna = session("Anna");
  const Reply begun = anna->call("campaign.start", {{"job", true}});
  const std::string id = begun.result->at("job").as_string().c_str();
  cell_.started.get_future().wait();
  const Notification notification_of_job = anna->notification();
  EXPECT_EQ(notification_of_job.method, "job");
  EXPECT_EQ(notification_of_job.params.at("id").as_string(), id);
  EXPECT_EQ(notification_of_job.params.at("doing").as_string(), "nothing");
  EXPECT_EQ(anna->call("cell.status").result->at("by").as_string(), "Anna");
  EXPECT_EQ(state(*anna->call("job.get", {{"id", id}}).result), "running");

  on_loop([this] { cell_.set_doing("waiting for the tracker"); });
  advance(1s);
  EXPECT_EQ(anna->notification().params.at("doing").as_string(), "waiting for the tracker");
  on_loop([this] { cell_.release(); });
  const Notification ended = anna->notification();
  EXPECT_EQ(state(ended.params), "done");
  EXPECT_FALSE(ended.params.contains("result"));
  const Reply known = anna->call("job.get", {{"id", id}});
  EXPECT_EQ(known.result->at("result").at("method").as_string(), "campaign.start");
}

TEST_F(ControlJobs, OutliveTheConnectionThatTheyWereAskedForBy) {
  serve();
  auto anna = session("Anna");
  const std::string id = anna->call("campaign.start", {{"job", true}}).result->at("job").as_string().c_str();
  cell_.started.get_future().wait();
  anna.reset();
  on_loop([this] { cell_.release(); });
  anna = session("Anna");
  Reply known = anna->call("job.get", {{"id", id}});
  while (known.result && state(*known.result) == "running") known = anna->call("job.get", {{"id", id}});
  EXPECT_EQ(state(*known.result), "done");
  EXPECT_EQ(session("Eve")->code("job.get", {{"id", id}}), -32004) << "of somebody else";
  advance(10min);
  EXPECT_EQ(session("Anna")->code("job.get", {{"id", id}}), -32004) << "forgotten";
}

TEST_F(ControlJobs, FailAsTheirCallsDo) {
  serve();
  const auto anna = session("Anna");
  const std::string id = anna->call("model.get", {{"job", true}}).result->at("job").as_string().c_str();
  Notification notification_of_job = anna->notification();
  while (state(notification_of_job.params) == "running") notification_of_job = anna->notification();
  EXPECT_EQ(state(notification_of_job.params), "failed");
  EXPECT_EQ(notification_of_job.params.at("error").at("code").as_int64(), -32603);
  EXPECT_THAT(std::string{notification_of_job.params.at("error").at("message").as_string()},
              HasSubstr("no such luck"));
  EXPECT_EQ(anna->code("campaign.start", {{"job", 1}}), -32602);
  EXPECT_EQ(anna->code("session.ping", {{"job", true}}), -32602) << "nothing that takes long";
}

TEST_F(ControlJobs, AreNoWayAroundRolesAndControl) {
  write_access({{control::entry_for_token("Anna", control::Role::Viewer, "token of Anna, long"),
                 control::entry_for_token("Eve", control::Role::Admin, "token of Eve, long")}});
  serve();
  const auto anna = session("Anna"), eve = session("Eve");
  EXPECT_EQ(anna->code("campaign.start", {{"job", true}}), -32002);
  EXPECT_EQ(anna->code("no.method", {{"job", true}}), -32601);
  Client owner{server_->port()};
  owner.hello();
  EXPECT_EQ(owner.code("control.acquire"), 0);
  EXPECT_EQ(eve->code("campaign.start", {{"job", true}}), 0);
  Notification notification_of_job = eve->notification();
  while (state(notification_of_job.params) == "running") notification_of_job = eve->notification();
  EXPECT_EQ(notification_of_job.params.at("error").at("code").as_int64(), -32008);
}

TEST_F(ControlJobs, EndWithTheServer) {
  serve();
  const auto anna = session("Anna");
  anna->call("campaign.start", {{"job", true}});
  cell_.started.get_future().wait();
  on_loop([this] { server_.reset(); });
  while (!anna->closed()) {
  }
}

}  // namespace
}  // namespace truepose::daemon
