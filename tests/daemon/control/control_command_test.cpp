// Who may command when somebody else has control, what is done twice, and what stands on record.
#include <gmock/gmock.h>

#include <algorithm>

#include "daemon/control/audit_trail.hpp"
#include "tests/daemon/control_fixture.hpp"
#include "tests/daemon/full_disk.hpp"
#include "tests/process.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::Role;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

/// Executes every command, and counts them.
class CountingCell : public CellService {
 public:
  std::vector<std::string> methods() const override {
    return {"campaign.abort",  "campaign.pause", "campaign.start",   "cell.acknowledge", "cell.connect",
            "cell.disconnect", "model.activate", "model.deactivate", "stream.disarm",    "stream.stop"};
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> call(std::string method, json::object params,
                                                                      std::string by) override {
    callers.push_back(std::move(by));
    calls.push_back(method);
    if (method == "campaign.start") {
      asio::steady_timer never{co_await asio::this_coro::executor, asio::steady_timer::time_point::max()};
      release = [&never] { never.cancel(); };
      const auto waited = co_await never.async_wait(asio::as_tuple(asio::use_awaitable));
      static_cast<void>(waited);
    }
    if (method == "model.activate")
      co_return std::unexpected(control::RpcError{control::ErrorCode::NotFound, "no such model"});
    json::object result{{"count", calls.size()}, {"params", params}};
    co_return result;
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> pause(std::string why,
                                                                       std::string by) override {
    callers.push_back(std::move(by));
    calls.push_back("pause: " + why);
    co_return json::object{};
  }
  void unrecorded(const std::string& why) override { whys.push_back(why); }
  void stand(bool stands, const Fault& fault) override {
    const std::string code{kind_of(fault.code).code};
    standing.erase(code);
    if (stands) standing[code] = fault.text;
  }
  std::vector<std::string> calls, callers, whys;
  std::map<std::string, std::string> standing;
  std::function<void()> release;
};

class ControlCommands : public ControlServerTest {
 protected:
  ControlCommands() {
    served_ = &counting_;
    write_access({{control::entry_for_token("Anna", Role::Operator, "token of Anna, long"),
                   control::entry_for_token("Bert", Role::Operator, "token of Bert, long"),
                   control::entry_for_token("Chef", Role::Engineer, "token of Chef, long")}});
  }
  ~ControlCommands() override { end_server(); }
  std::unique_ptr<Client> session(std::uint16_t port, const std::string& name) {
    auto client = std::make_unique<Client>(port);
    EXPECT_EQ(Client::code_of(client->hello("token of " + name + ", long")), 0);
    return client;
  }
  std::vector<std::string> calls() {
    std::vector<std::string> all;
    on_loop([&] { all = counting_.calls; });
    return all;
  }
  std::vector<std::string> why_unrecorded() {
    std::vector<std::string> all;
    on_loop([&] { all = counting_.whys; });
    return all;
  }
  /// "Anna stream.stop", and of what became of it "1 ok".
  std::vector<std::string> on_record(Client& client) {
    std::vector<std::string> lines;
    const Reply reply = client.call("audit.list");
    for (const json::value& record : reply.result->at("records").as_array()) {
      const json::object& r = record.as_object();
      lines.insert(lines.begin(),
                   r.contains("who")
                       ? std::string{r.at("who").as_string()} + " " + r.at("method").as_string().c_str()
                       : std::to_string(r.at("of").as_int64()) + " " + r.at("result").as_string().c_str());
    }
    return lines;
  }
  void end_server() {
    on_loop([this] { server_.reset(); });
  }
  void until_called(const std::string& method) {
    while (std::ranges::count(calls(), method) == 0) {
    }
  }

  CountingCell counting_;
};

TEST_F(ControlCommands, AreEverybodysWhileNobodyHasControl) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  EXPECT_EQ(anna->code("stream.stop"), 0);
  EXPECT_EQ(bert->code("stream.stop"), 0);
  EXPECT_TRUE(anna->call("control.get").result->at("holder").is_null());
}

TEST_F(ControlCommands, OfOthersAreRefusedWhileSomebodyHasControl) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert"), anna_too = session(port, "Anna");
  EXPECT_EQ(anna->call("control.acquire", {{"lease_s", 60}}).result->at("left_s").as_int64(), 60);
  const Reply refused = bert->call("cell.connect");
  EXPECT_EQ(Client::code_of(refused), -32008);
  EXPECT_THAT(refused.result.error().message, HasSubstr("Anna (operator) has control, for 60 s more"));
  EXPECT_EQ(bert->code("control.acquire"), -32008);
  EXPECT_EQ(bert->code("control.takeover"), -32008) << "from one of the same role";
  EXPECT_EQ(anna_too->code("cell.connect"), 0) << "a panel's second connection";
  EXPECT_THAT(calls(), ElementsAre("cell.connect"));
  EXPECT_EQ(bert->call("control.release").result->at("holder").as_string(), "Anna") << "not his to give back";
  EXPECT_EQ(anna->code("control.release"), 0);
  EXPECT_EQ(bert->code("cell.connect"), 0);
}

TEST_F(ControlCommands, ThatTakeMotionOrControlAwayAreEverybodysWhoeverHasControl) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert"), chef = session(port, "Chef");
  anna->call("control.acquire");
  for (const char* const stop : {"campaign.pause", "campaign.abort", "stream.stop", "stream.disarm",
                                 "cell.disconnect", "cell.acknowledge"})
    EXPECT_EQ(bert->code(stop), 0) << stop;
  EXPECT_EQ(chef->code("model.deactivate"), 0);
  EXPECT_EQ(bert->code("cell.connect"), -32008);
  EXPECT_EQ(bert->call("control.get").result->at("holder").as_string(), "Anna") << "who keeps it";
}

TEST_F(ControlCommands, OfOthersAreRefusedForAMinuteAtMost) {
  const auto anna = session(serve(), "Anna");
  EXPECT_EQ(anna->code("control.acquire", {{"lease_s", 61}}), -32602);
  EXPECT_EQ(anna->code("control.takeover", {{"lease_s", 61}}), -32602);
}

TEST_F(ControlCommands, AreEverybodysTenSecondsAfterTheHoldersLastConnection) {
  const auto port = serve({.idle = 1h});
  auto anna = session(port, "Anna"), anna_too = session(port, "Anna");
  const auto bert = session(port, "Bert");
  bert->call("events.subscribe", {{"topics", {"control"}}});
  anna->call("control.acquire", {{"lease_s", 60}});
  EXPECT_EQ(bert->event().data.at("change").as_string(), "acquired");
  const auto leave = [&](std::unique_ptr<Client>& who, std::size_t left) {
    who.reset();
    await("the connection has ended", [&] {
      std::size_t open = 0;
      on_loop([&] { open = server_->load().sessions; });
      return open == left;
    });
  };
  /// The session is gone a moment before the lease knows of it.
  const auto leave_for_good = [&] {
    leave(anna, 1);
    await("the ten seconds run",
          [&] { return bert->call("control.get").result->at("left_s").as_int64() <= 10; });
  };
  leave(anna_too, 2);
  advance(15s);
  EXPECT_EQ(bert->code("cell.connect"), -32008) << "she has another";
  leave_for_good();
  advance(8s);
  EXPECT_EQ(bert->call("control.get").result->at("left_s").as_int64(), 2);
  anna = session(port, "Anna");
  EXPECT_EQ(bert->call("control.get").result->at("left_s").as_int64(), 37) << "she is back";
  leave_for_good();
  advance(10s);
  const Event lost = bert->event();
  EXPECT_EQ(lost.data.at("change").as_string(), "lost");
  EXPECT_EQ(bert->event().data.at("method").as_string(), "campaign.pause");
  EXPECT_THAT(calls(), ElementsAre("pause: the last connection of Anna, who had control, ended 10 s ago"));
  EXPECT_EQ(bert->code("cell.connect"), 0);
}

TEST_F(ControlCommands, PassToAHigherRoleThatTakesControlOver) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), chef = session(port, "Chef");
  anna->call("control.acquire");
  EXPECT_EQ(chef->code("cell.connect"), -32008) << "before it is taken over";
  EXPECT_EQ(chef->call("control.takeover").result->at("holder").as_string(), "Chef");
  EXPECT_EQ(anna->code("cell.connect"), -32008);
}

TEST_F(ControlCommands, OfOneWhoDoesNotRenewControlAreFollowedByAPause) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  bert->call("events.subscribe", {{"topics", {"control"}}});
  anna->call("control.acquire", {{"lease_s", 10}});
  EXPECT_EQ(bert->event().data.at("change").as_string(), "acquired");
  advance(8s);
  anna->call("control.acquire", {{"lease_s", 10}});
  advance(8s);
  EXPECT_EQ(bert->code("cell.connect"), -32008) << "it was renewed";
  advance(4s);
  const Event lost = bert->event();
  EXPECT_EQ(lost.data.at("change").as_string(), "lost");
  EXPECT_EQ(lost.data.at("by").as_string(), "Anna");
  const Event paused = bert->event();
  EXPECT_EQ(paused.data.at("method").as_string(), "campaign.pause");
  EXPECT_EQ(paused.data.at("by").as_string(), "trueposed");
  EXPECT_THAT(calls(), ElementsAre("pause: Anna has not renewed its control"));
}

TEST_F(ControlCommands, OfWhoTakesControlNextComeAfterThePause) {
  const auto port = serve({.look = 1h});
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  anna->call("control.acquire", {{"lease_s", 10}});
  advance(10s);
  EXPECT_EQ(bert->code("control.acquire"), 0);
  EXPECT_EQ(bert->code("cell.connect"), 0);
  EXPECT_THAT(calls(), ElementsAre("pause: Anna has not renewed its control", "cell.connect"));
}

TEST_F(ControlCommands, ArePausedForAtTheVeryEndOfALease) {
  const auto port = serve({.look = 4s});
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  anna->call("control.acquire", {{"lease_s", 5}});
  bert->call("events.subscribe", {{"topics", {"control"}}});
  advance(4s);
  EXPECT_TRUE(calls().empty());
  advance(1s);
  EXPECT_EQ(bert->event().data.at("change").as_string(), "lost");
  EXPECT_EQ(bert->event().data.at("method").as_string(), "campaign.pause");
}

TEST_F(ControlCommands, AreEverybodysOnceWhoHadControlIsLetInNoMore) {
  control::AccessEntries access{{control::entry_for_token("Bert", Role::Operator, "token of Bert, long"),
                                 control::entry_for_token("Anna", Role::Operator, "token of Anna, long")}};
  write_access(access);
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  bert->call("events.subscribe", {{"topics", {"control"}}});
  anna->call("control.acquire", {{"lease_s", 60}});
  EXPECT_EQ(bert->event().data.at("change").as_string(), "acquired");
  access.entries.pop_back();
  write_access(access);
  advance(2s);
  const Event lost = bert->event();
  EXPECT_EQ(lost.data.at("change").as_string(), "lost");
  EXPECT_EQ(lost.data.at("by").as_string(), "Anna");
  EXPECT_EQ(bert->event().data.at("method").as_string(), "campaign.pause");
  EXPECT_THAT(calls(),
              ElementsAre(HasSubstr("pause: the access of Anna, who had control, was changed or revoked")));
}

TEST_F(ControlCommands, WithTheSameIdAreDoneOnceAndAnsweredAlike) {
  const auto port = serve({.idle = 1h});
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  const json::object once{{"command_id", "c1"}};
  const Reply first = anna->call("stream.stop", once);
  const auto again = session(port, "Anna");
  EXPECT_EQ(*again->call("stream.stop", once).result, *first.result);
  EXPECT_EQ(calls().size(), 1U);
  EXPECT_FALSE(first.result->at("params").as_object().contains("command_id"));
  EXPECT_EQ(anna->code("campaign.pause", once), -32602) << "another command of that id";
  EXPECT_EQ(bert->code("stream.stop", once), 0) << "another's";
  EXPECT_EQ(calls().size(), 2U);
  EXPECT_EQ(session(port, "Chef")->code("model.activate", {{"command_id", "c2"}}), -32004);
  EXPECT_EQ(anna->code("stream.stop", {{"command_id", ""}}), -32602);
  advance(10min);
  EXPECT_EQ(anna->code("stream.stop", once), 0);
  EXPECT_EQ(calls().size(), 4U) << "ten minutes later it is a new one";
}

TEST_F(ControlCommands, AreKnownAgainByTheDaemonThatComesAfter) {
  const json::object once{{"command_id", "c1"}, {"pose", 1.5}};
  const Reply first = session(serve(), "Anna")->call("stream.stop", once);
  end_server();
  const auto port = serve({.idle = 1h});
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  EXPECT_EQ(*anna->call("stream.stop", once).result, *first.result);
  EXPECT_EQ(calls().size(), 1U);
  EXPECT_EQ(anna->code("stream.stop", {{"command_id", "c1"}}), -32602) << "another command of that id";
  EXPECT_EQ(bert->code("stream.stop", once), 0) << "another's";
  EXPECT_EQ(anna->code("stream.stop", {{"command_id", "c2"}}), 0) << "a new one";
  EXPECT_EQ(calls().size(), 3U);
}

TEST_F(ControlCommands, ThatWereRefusedBeforeARestartMayComeAgain) {
  const json::object once{{"command_id", "c1"}};
  EXPECT_EQ(session(serve(), "Chef")->code("model.activate", once), -32004);
  end_server();
  EXPECT_EQ(session(serve(), "Chef")->code("model.activate", once), -32004);
  EXPECT_EQ(calls().size(), 2U);
}

TEST_F(ControlCommands, OfWhichNoEndStandsOnRecordAreNotDoneASecondTime) {
  const json::object once{{"command_id", "c1"}};
  const auto port = serve();
  session(port, "Anna")->send(control::encode_request(50, "campaign.start", once));
  until_called("campaign.start");
  const fs::path as_killed = folder_.path() / "as killed";
  for (const char* end : {"", ".head"}) fs::copy(audit_file().string() + end, as_killed.string() + end);
  on_loop([this] { counting_.release(); });
  end_server();
  for (const char* end : {"", ".head"}) fs::rename(as_killed.string() + end, audit_file().string() + end);
  const auto anna = session(serve(), "Anna");
  const Reply refused = anna->call("campaign.start", once);
  EXPECT_EQ(Client::code_of(refused), -32602);
  EXPECT_THAT(refused.result.error().message,
              HasSubstr("whether it was carried out is not known; see cell.status"));
  EXPECT_EQ(calls().size(), 1U);
}

TEST_F(ControlCommands, OfBeforeARestartAreKnownForTenMinutesWhateverTheClocksWereSetTo) {
  const json::object once{{"command_id", "c1"}};
  {
    const auto anna = session(serve(), "Anna");
    EXPECT_EQ(anna->code("stream.stop", once), 0);
    on_loop([this] { wall_ -= 1h; });
    EXPECT_EQ(anna->code("stream.stop"), 0);
  }
  end_server();
  wall_ += 25h;
  const auto anna = session(serve({.idle = 1h}), "Anna");
  EXPECT_EQ(anna->code("stream.stop", once), 0);
  EXPECT_EQ(calls().size(), 2U);
  advance(10min);
  EXPECT_EQ(anna->code("stream.stop", once), 0);
  EXPECT_EQ(calls().size(), 3U) << "ten minutes later it is a new one";
}

TEST_F(ControlCommands, OfBeforeARestartAreJudgedByTheLastOneOfTheirId) {
  const json::object once{{"command_id", "c1"}};
  {
    const auto chef = session(serve({.idle = 1h}), "Chef");
    EXPECT_EQ(chef->code("stream.stop", once), 0);
    advance(10min);
    EXPECT_EQ(chef->code("model.activate", once), -32004);
  }
  end_server();
  EXPECT_EQ(session(serve(), "Chef")->code("model.activate", once), -32004) << "it was refused: tried again";
  EXPECT_EQ(calls().size(), 3U);
}

TEST_F(ControlCommands, ThatAreUnderWayAreWaitedForByTheirRepetition) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), again = session(port, "Anna");
  const json::object once{{"command_id", "c1"}};
  anna->send(control::encode_request(50, "campaign.start", once));
  until_called("campaign.start");
  again->send(control::encode_request(51, "campaign.start", once));
  on_loop([this] { counting_.release(); });
  EXPECT_EQ(*anna->reply().result, *again->reply().result);
  EXPECT_EQ(calls().size(), 1U);
}

TEST_F(ControlCommands, RefusedForWantOfControlMayComeAgainWithTheirId) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), bert = session(port, "Bert");
  anna->call("control.acquire");
  EXPECT_EQ(bert->code("cell.connect", {{"command_id", "b1"}}), -32008);
  anna->call("control.release");
  EXPECT_EQ(bert->code("cell.connect", {{"command_id", "b1"}}), 0);
}

TEST_F(ControlCommands, StandOnRecordWithWhatBecameOfThem) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), chef = session(port, "Chef");
  anna->call("stream.stop");
  anna->call("model.activate");
  chef->call("model.activate", {{"id", "x"}});
  EXPECT_THAT(on_record(*anna),
              ElementsAre("Anna stream.stop", "1 ok", "Chef model.activate", "3 E_NOT_FOUND"))
      << "what a role may not do is not begun";
  const json::value record =
      anna->call("audit.list", {{"before", 4}, {"limit", 1}}).result->at("records").at(0);
  EXPECT_EQ(record.at("from").as_string(), "loopback");
  EXPECT_EQ(record.at("params").at("id").as_string(), "x");
  EXPECT_EQ(verify_audit(audit_file())->end.count, 4U);
}

TEST_F(ControlCommands, PutOnRecordWhenControlChangesHandsAndNotThatItIsRenewed) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), chef = session(port, "Chef");
  for (int i = 0; i < 100; ++i) EXPECT_EQ(anna->code("control.acquire"), 0);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(chef->code("control.takeover"), 0);
  chef->call("control.release");
  EXPECT_THAT(on_record(*anna), ElementsAre("Anna control.acquire", "1 ok", "Chef control.takeover", "3 ok",
                                            "Chef control.release", "5 ok"));
}

TEST_F(ControlCommands, ThatCannotBePutOnRecordAreNotDone) {
  const auto port = serve();
  const auto anna = session(port, "Anna");
  EXPECT_EQ(anna->code("stream.stop"), 0);
  Reply refused;
  {
    const FullDisk full;
    refused = anna->call("campaign.start");
  }
  ASSERT_FALSE(refused.result);
  EXPECT_EQ(Client::code_of(refused), -32009);
  EXPECT_THAT(refused.result.error().message,
              AllOf(HasSubstr("not carried out, since the audit log cannot be written: File too large"),
                    HasSubstr("make room on the disk, then cell.acknowledge")));
  EXPECT_EQ(calls().size(), 1U);
  EXPECT_THAT(why_unrecorded(), ElementsAre(HasSubstr("audit trail cannot be written: File too large")));
}

TEST_F(ControlCommands, AreNotDoneWhileTheirTrailIsGoneAndItIsPutBackWithTheNameOfWhoSaysSo) {
  const auto port = serve();
  const auto anna = session(port, "Anna");
  Client admin{port};
  admin.hello();
  EXPECT_EQ(anna->code("cell.connect"), 0);
  EXPECT_EQ(admin.code("audit.acknowledge", {{"name", "Anna Beer"}}), -32003) << "nothing is wrong";
  for (const fs::path& lost : {audit_file(), audit_head_of(audit_file())}) {
    fs::remove(lost);
    await("it is found", [&] {
      advance(1s);
      return !why_unrecorded().empty();
    });
    EXPECT_THAT(why_unrecorded().front(), AllOf(HasSubstr(lost.string() + ": was deleted"),
                                                HasSubstr("truepose audit acknowledge --name NAME")));
    const std::size_t done = calls().size();
    EXPECT_EQ(anna->code("cell.connect"), -32009);
    EXPECT_EQ(anna->code("cell.acknowledge"), -32009) << "that does not put it back";
    EXPECT_EQ(calls().size(), done) << "off record";
    EXPECT_EQ(anna->code("stream.stop"), 0) << "but for what stops something";
    EXPECT_EQ(anna->code("audit.acknowledge", {{"name", "Anna Beer"}}), -32002);
    EXPECT_EQ(admin.code("audit.acknowledge", {{"name", " "}}), -32602);
    const Reply acknowledged = admin.call("audit.acknowledge", {{"name", "Anna Beer"}});
    ASSERT_TRUE(acknowledged.result) << acknowledged.result.error().message;
    EXPECT_THAT(acknowledged.result->at("acknowledged").as_string().c_str(), HasSubstr("was deleted"));
    EXPECT_EQ(anna->code("cell.connect"), 0);
    on_loop([this] {
      counting_.whys.clear();
      EXPECT_FALSE(counting_.standing.contains("E_AUDIT"));
    });
  }
  const auto report = verify_audit(audit_file());
  ASSERT_TRUE(report) << report.error();
  ASSERT_EQ(report->faults.size(), 2U);
  EXPECT_EQ(report->faults[1].acknowledged_by, "Anna Beer (token file)");
  EXPECT_EQ(report->end.count, 2 + 2 * (1 + 4 + 2 + 2)) << "nothing of it is lost";
}

TEST_F(ControlCommands, OfATrailThatWasChangedMeanwhileStandAsAFaultUntilAnAdminAcknowledgesIt) {
  EXPECT_EQ(session(serve(), "Anna")->code("cell.connect"), 0);
  end_server();
  std::string changed = text_of(audit_file());
  changed[changed.find("Anna")] = 'H';
  std::ofstream{audit_file()} << changed;
  Client admin{serve()};
  admin.hello();
  on_loop([this] { EXPECT_THAT(counting_.standing.at("E_AUDIT"), HasSubstr("record 2 was changed")); });
  EXPECT_EQ(admin.code("audit.acknowledge", {{"name", "Anna Beer"}}), 0);
  on_loop([this] { EXPECT_FALSE(counting_.standing.contains("E_AUDIT")); });
}

TEST_F(ControlCommands, ThatStopSomethingAreDoneOnAFullDiskAndPutOnRecordWhenThereIsRoom) {
  const auto port = serve();
  const auto anna = session(port, "Anna"), chef = session(port, "Chef");
  EXPECT_EQ(anna->code("stream.stop"), 0);
  anna->call("control.acquire");
  {
    const FullDisk full;
    EXPECT_EQ(chef->code("control.takeover"), 0) << "who would stop it may need control";
    EXPECT_EQ(chef->code("stream.stop"), 0);
    EXPECT_EQ(chef->code("campaign.pause"), 0);
    EXPECT_EQ(chef->code("campaign.start"), -32009);
  }
  EXPECT_THAT(calls(), ElementsAre("stream.stop", "stream.stop", "campaign.pause"));
  EXPECT_EQ(chef->code("control.release"), 0);
  EXPECT_THAT(on_record(*chef), ElementsAre("Anna stream.stop", "1 ok", "Anna control.acquire", "3 ok",
                                            "Chef control.takeover", "5 ok", "Chef stream.stop", "7 ok",
                                            "Chef campaign.pause", "9 ok", "Chef control.release", "11 ok"));
  EXPECT_EQ(verify_audit(audit_file())->end.count, 12U);
}

TEST_F(ControlCommands, AreWrittenDownByThemselvesOnceThereIsRoom) {
  const auto port = serve();
  const auto anna = session(port, "Anna");
  {
    const FullDisk full;
    EXPECT_EQ(anna->code("stream.stop"), 0);
  }
  EXPECT_EQ(on_record(*anna).size(), 0U);
  while (on_record(*anna).size() < 2) advance(ControlLimits{}.look);
}

}  // namespace
}  // namespace truepose::daemon
