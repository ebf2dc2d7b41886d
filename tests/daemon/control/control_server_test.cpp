#include <gmock/gmock.h>
#include <unistd.h>

#include <random>

#include "daemon/control/acceptor.hpp"
#include "daemon/control/connection.hpp"
#include "daemon/control/failed_logins.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/control/session_proof.hpp"
#include "proto/rpc/methods.hpp"
#include "tests/daemon/control_fixture.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::Topic;
using testing::HasSubstr;

TEST_F(ControlServerTest, LetsWhoConnectsWaitUntilTheCellCanAnswer) {
  ASSERT_EQ(try_start({"127.0.0.1", 0}).text, "");
  Client early{server_->port()};
  early.send_hello(kToken);
  for (int turn = 0; turn < 5; ++turn) on_loop([this] { EXPECT_EQ(server_->load().connections, 0U); });
  on_loop([this] { server_->serve(); });
  EXPECT_TRUE(early.reply().result);
}

TEST_F(ControlServerTest, AnswersAfterSessionHello) {
  Client client{serve()};
  const Reply hello = client.hello();
  ASSERT_TRUE(hello.result);
  EXPECT_EQ(hello.result->at("cell").as_string(), "cell 1");
  EXPECT_EQ(hello.result->at("time").as_string(), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(client.call("cell.status").result->at("method").as_string(), "cell.status");
  EXPECT_EQ(client.call("system.info").result->at("connections").as_int64(), 1);
}

TEST_F(ControlServerTest, WantsSessionHelloFirst) {
  Client client{serve()};
  EXPECT_EQ(client.code("cell.status"), -32001);
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlServerTest, ClosesAfterAWrongTokenAnotherProtocolOrGarbage) {
  const auto port = serve();
  for (const std::string_view token : {"", "0123456789abcdef0123456789abcdeF", "0123456789abcdef"}) {
    Client client{port};
    EXPECT_EQ(Client::code_of(client.hello(token)), -32001) << token;
    EXPECT_TRUE(client.closed());
  }
  Client other{port};
  EXPECT_EQ(other.code("session.hello", {{"protocol", 2}, {"token", std::string{kToken}}}), -32602);
  EXPECT_TRUE(other.closed());
  Client garbage{port};
  garbage.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(Client::code_of(garbage.reply()), -32700);
  EXPECT_TRUE(garbage.closed());
}

TEST_F(ControlServerTest, AnswersAPeerThatGuessesTokensLateAndLetsTheRightTokenIn) {
  const auto port = serve({.hello_failures = 2, .hello_delay = 1s, .look = 1h});
  for (int guess = 0; guess < 2; ++guess) EXPECT_EQ(Client::code_of(Client{port}.hello("wrong")), -32001);
  Client wrong{port}, right{port};
  wrong.send_hello("wrong");
  right.send_hello(kToken);
  wait_for_hellos(2);
  EXPECT_TRUE(wrong.nothing_came());
  EXPECT_TRUE(right.nothing_came());
  advance(1s);
  EXPECT_EQ(Client::code_of(wrong.reply()), -32001);
  EXPECT_EQ(Client::code_of(right.reply()), 0);
  advance(60s);
  EXPECT_EQ(Client::code_of(Client{port}.hello()), 0);  // at once: time does not pass here
}

TEST(FailedLogins, AreForgottenAfterTheWindowAndOfVeryManyPeersTheOldest) {
  FailedLogins failed_logins{60s};
  const drivers::TimePoint begin{};
  failed_logins.count("::1", begin);
  failed_logins.count("::1", begin + 30s);
  EXPECT_EQ(failed_logins.of("::1", begin + 59s), 2U);
  EXPECT_EQ(failed_logins.of("::1", begin + 60s), 1U);
  EXPECT_EQ(failed_logins.of("::2", begin + 60s), 0U);
  EXPECT_EQ(failed_logins.peers(), 1U) << "who only asked is remembered";
  EXPECT_EQ(failed_logins.of("::1", begin + 90s), 0U);
  EXPECT_EQ(failed_logins.peers(), 0U);
  for (std::size_t i = 0; i < FailedLogins::kMostPeers; ++i)
    failed_logins.count(std::to_string(i), begin + 90s + std::chrono::milliseconds{i});
  failed_logins.count("one more", begin + 92s);
  EXPECT_EQ(failed_logins.peers(), FailedLogins::kMostPeers);
  EXPECT_EQ(failed_logins.of("0", begin + 92s), 0U);
  EXPECT_EQ(failed_logins.of("1", begin + 92s), 1U);
}

TEST_F(ControlServerTest, LetsTheRightTokenInHoweverManyConnectionsStandAndGuess) {
  const auto port = serve({.guests_of_peer = 2, .hello_failures = 1, .hello_delay = 1s, .look = 1h});
  EXPECT_EQ(Client::code_of(Client{port}.hello("wrong")), -32001);
  Client right{port};
  right.send_hello(kToken);
  wait_for_hellos(1);
  std::vector<std::unique_ptr<Client>> crowd;
  for (int i = 0; i < 20; ++i) {
    crowd.push_back(std::make_unique<Client>(port));
    if (i % 2 == 0) crowd.back()->send_hello("wrong");
  }
  for (int i = 0; i < 19; ++i) ASSERT_TRUE(crowd[static_cast<std::size_t>(i)]->closed()) << i;
  advance(1s);
  EXPECT_EQ(Client::code_of(right.reply()), 0);
}

TEST_F(ControlServerTest, KeepsPlacesForSessionsThatSilentConnectionsCannotTake) {
  const auto port = serve({.sessions = 2, .guests_of_peer = 3});
  Client first{port};
  first.hello();
  std::vector<std::unique_ptr<Client>> crowd;
  for (int i = 0; i < 50; ++i) crowd.push_back(std::make_unique<Client>(port));
  Client second{port};
  EXPECT_EQ(Client::code_of(second.hello()), 0);
  EXPECT_EQ(first.code("cell.status"), 0);
}

TEST_F(ControlServerTest, LeavesPlacesToOtherPeers) {
  const auto port = serve({.of_one_peer = 1});
  Client over_tcp{port}, another{port};
  EXPECT_EQ(Client::code_of(over_tcp.hello()), 0);
  EXPECT_THAT(another.hello().result.error().message, HasSubstr("loopback has 1 sessions open already"));
  Client local{socket()};
  EXPECT_EQ(local.code("session.hello", {{"protocol", 1}}), 0);
}

TEST_F(ControlServerTest, LeavesPlacesToOtherPeersWhereOneGetsTheReasonOfItsClosedConnections) {
  const auto port = serve({.sessions = 2, .guests_of_peer = 2});
  std::vector<std::unique_ptr<Client>> crowd;
  for (int i = 0; i < 12; ++i) {
    crowd.push_back(std::make_unique<Client>(port));
    crowd.back()->send(std::string(2 * control::kMaxLineBeforeHello, 'x'));
    crowd.back()->line();  // why it is closed
  }
  Client local{socket()};
  EXPECT_EQ(local.code("session.hello", {{"protocol", 1}}), 0);
}

TEST(PeerOfAClient, HasANameAlsoWhereTheClientHasGone) {
  asio::io_context io;
  EXPECT_EQ(Peer::of(*net::tcp_stream(io.get_executor())).name, "a client that has gone");
}

TEST(AcceptWhoStays, LeavesOutWhoeverHasHungUpAndSaidNothing) {
  asio::io_context io;
  const auto listener = *net::listen_tcp(io.get_executor(), "127.0.0.1", 0);
  const tcp::endpoint there{asio::ip::address_v4::loopback(), listener->local().port};
  const auto connect = [&](tcp::socket& socket) { socket.connect(there); };
  for (int i = 0; i < 3; ++i) {
    tcp::socket gone{io};
    connect(gone);
  }
  tcp::socket stays{io}, has_spoken{io};
  connect(stays);
  connect(has_spoken);
  asio::write(has_spoken, asio::buffer("x", 1));
  has_spoken.shutdown(tcp::socket::shutdown_send);
  std::vector<std::unique_ptr<net::Stream>> admitted;
  const auto admit = [&](std::unique_ptr<net::Stream> stream) {
    admitted.push_back(std::move(stream));
    if (admitted.size() == 2) listener->close();
  };
  accept_who_stays(
      listener, [](const std::string&) {}, "test", admit);
  io.run();
  ASSERT_EQ(admitted.size(), 2U);
  EXPECT_EQ(admitted[0]->remote().port, stays.local_endpoint().port());
  EXPECT_EQ(admitted[1]->remote().port, has_spoken.local_endpoint().port());
}

TEST_F(ControlServerTest, TakesNoTokenWhereTheKernelSaysWhoAsks) {
  const auto port = serve();
  EXPECT_EQ(fs::status(socket()).permissions(), fs::perms{0660});
  Client local{socket()};
  EXPECT_EQ(local.code("session.hello", {{"protocol", 1}}), 0);
  EXPECT_EQ(local.code("cell.status"), 0);
  EXPECT_EQ(Client{socket()}.code("session.hello", {{"protocol", 1}, {"token", "wrong"}}), -32001);
  EXPECT_EQ(Client{port}.code("session.hello", {{"protocol", 1}}), -32602);
}

TEST_F(ControlServerTest, TakesTheSocketOverThatADeadDaemonLeft) {
  {
    asio::io_context context;
    const asio::local::stream_protocol::acceptor dead{context, {socket().string()}};
  }
  ASSERT_TRUE(fs::exists(socket()));
  serve();
  EXPECT_EQ(Client{socket()}.code("session.hello", {{"protocol", 1}}), 0);
  on_loop([this] { server_.reset(); });
  EXPECT_FALSE(fs::exists(socket()));
}

TEST_F(ControlServerTest, OpensASessionForAClientThatProvesThatItKnowsTheToken) {
  const auto port = serve();
  const auto hello = [&](Client& client, const std::string& token, const std::string& endpoint) {
    const Reply challenge = client.call("session.challenge");
    const control::SessionTerms terms{endpoint, control::new_nonce(kernel_random),
                                      challenge.result->at("nonce").as_string().c_str()};
    const Reply reply =
        client.call("session.hello", {{"protocol", 1},
                                      {"nonce", terms.client_nonce},
                                      {"proof", session_proof(token, control::Prover::Client, terms)}});
    if (reply.result) {
      EXPECT_EQ(reply.result->at("proof").as_string(), session_proof(kToken, control::Prover::Server, terms));
    }
    return Client::code_of(reply);
  };
  const std::string here = "127.0.0.1 " + std::to_string(port), token{kToken};
  Client right{port}, wrong{port}, relayed{port}, unasked{port};
  EXPECT_EQ(hello(right, token, here), 0);
  EXPECT_EQ(right.code("cell.status"), 0);
  EXPECT_EQ(hello(wrong, "another token of some length", here), -32001);
  EXPECT_EQ(hello(relayed, token, "127.0.0.1 1"), -32001);  // made for a program at another port
  const control::SessionTerms without{
      {}, control::new_nonce(kernel_random), {}};  // what a server that was not asked has
  EXPECT_EQ(
      unasked.code("session.hello", {{"protocol", 1},
                                     {"nonce", without.client_nonce},
                                     {"proof", session_proof(token, control::Prover::Client, without)}}),
      -32001);
}

TEST_F(ControlServerTest, SaysWhenAMethodIsUnknownOrWhatItWasGivenIsWrong) {
  Client client{serve()};
  client.hello();
  EXPECT_EQ(client.code("audit.forget"), -32601);
  EXPECT_EQ(client.code("session.hello"), -32600);
  EXPECT_EQ(client.code("system.info", {{"x", 1}}), -32602);
  EXPECT_EQ(client.code("events.subscribe", {{"topics", {"cell", "weather"}}}), -32602);
  EXPECT_EQ(client.code("events.subscribe", {{"after", 1'000'000}}), -32602);
  EXPECT_EQ(client.code("cell.status"), 0);
}

TEST_F(ControlServerTest, AnswersADefectOfTheCellAndAnAnswerTooLongAsInternalErrors) {
  Client client{serve()};
  client.hello();
  EXPECT_THAT(client.call("model.get").result.error().message, HasSubstr("no such luck"));
  EXPECT_EQ(client.code("report.get"), -32603);
  EXPECT_EQ(client.code("cell.status"), 0);
}

TEST_F(ControlServerTest, NeverAnswersANotification) {
  Client client{serve()};
  client.hello();
  client.send(control::encode_request({}, "cell.status", {}));
  EXPECT_EQ(client.code("cell.status"), 0);  // whose id is checked: nothing came between
}

TEST_F(ControlServerTest, AnswersGarbageWithErrorsAndGoesOn) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  Client client{serve()};
  client.hello();
  for (int trial = 0; trial < 200; ++trial) {
    std::string line(1 + random() % 100, ' ');
    for (char& byte : line) byte = static_cast<char>(random());
    std::erase(line, '\n');
    client.send("\x01" + line + "\n");
    EXPECT_EQ(Client::code_of(client.reply()), -32700);
  }
  EXPECT_EQ(client.code("cell.status"), 0);
}

TEST_F(ControlServerTest, ClosesOnALineThatIsTooLongAndSaysSo) {
  const auto port = serve();
  Client stranger{port};
  stranger.send(std::string(4097, 'x'));
  EXPECT_THAT(stranger.reply().result.error().message, HasSubstr("4096 bytes"));
  EXPECT_TRUE(stranger.closed());
  Client client{port};
  client.hello();
  client.send(std::string(200'000, 'x'));
  EXPECT_THAT(client.reply().result.error().message, HasSubstr("65536 bytes"));
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlServerTest, ServesOthersWhileOneCallTakesLong) {
  const auto port = serve();
  Client slow{port};
  Client quick{port};
  slow.hello();
  quick.hello();
  slow.send(control::encode_request(71, "campaign.start", {}));
  slow.send(control::encode_request(72, "cell.status", {}));
  cell_.started.get_future().wait();
  EXPECT_EQ(quick.code("cell.status"), 0);
  on_loop([this] { cell_.release(); });
  EXPECT_EQ(slow.reply().id, control::Id{71});
  EXPECT_EQ(slow.reply().id, control::Id{72});
}

TEST_F(ControlServerTest, DoesNotTakeALongCallForIdleness) {
  Client client{serve()};
  client.hello();
  client.send(control::encode_request(9, "campaign.start", {}));
  cell_.started.get_future().wait();
  advance(1h);
  on_loop([this] { cell_.release(); });
  EXPECT_EQ(client.reply().id, control::Id{9});
  EXPECT_EQ(client.code("cell.status"), 0);
}

TEST_F(ControlServerTest, AnswersAClientThatHasAlreadyEndedItsInput) {
  Client client{serve()};
  client.send(control::encode_request(1, "session.hello", {{"protocol", 1}, {"token", std::string{kToken}}}) +
              control::encode_request(2, "cell.status", {}));
  client.end_of_input();
  EXPECT_EQ(client.reply().id, control::Id{1});
  EXPECT_EQ(client.reply().id, control::Id{2});
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlServerTest, ClosesWhoeverStaysSilentOrDawdles) {
  const auto port = serve();
  Client silent{port};
  Client dawdler{port};
  dawdler.hello();
  dawdler.send("{");
  Client witness{port};
  witness.hello();  // answered after the others' bytes have been read
  witness.call("events.subscribe");
  advance(3s);
  EXPECT_THAT(silent.reply().result.error().message, HasSubstr("session.hello"));
  EXPECT_TRUE(silent.closed());
  advance(7s);
  EXPECT_THAT(dawdler.reply().result.error().message, HasSubstr("did not end"));
  EXPECT_TRUE(dawdler.closed());
  advance(24h);
  EXPECT_EQ(witness.code("cell.status"), 0);  // a subscriber may listen for days
}

TEST_F(ControlServerTest, RefusesMoreSessionsThanItMayHold) {
  const auto port = serve({.sessions = 2});
  Client first{port};
  Client second{port};
  first.hello();
  second.hello();
  EXPECT_THAT(Client{port}.hello().result.error().message, HasSubstr("2 sessions"));
}

TEST_F(ControlServerTest, SendsEachSubscriberItsTopics) {
  const auto port = serve();
  Client all{port};
  Client faults{port};
  all.hello();
  faults.hello();
  all.call("events.subscribe");
  faults.call("events.subscribe", {{"topics", {"fault"}}});
  events_.publish(Topic::Cell, json::object{{"state", "ready"}});
  events_.publish(Topic::Fault, json::object{{"code", "E_BEAM"}});
  EXPECT_EQ(all.event().seq, 1000U);
  EXPECT_EQ(all.event().topic, "fault");
  EXPECT_EQ(faults.event().seq, 1001U);
  EXPECT_EQ(faults.call("events.unsubscribe").result->at("topics").as_array().size(), 0U);
  events_.publish(Topic::Fault, json::object{});
  EXPECT_EQ(faults.code("cell.status"), 0);
}

TEST_F(ControlServerTest, ReplaysWhatAClientMissed) {
  for (int i = 0; i < 10; ++i) events_.publish(i % 2 ? Topic::Log : Topic::Cell, json::object{{"i", i}});
  Client client{serve()};
  client.hello();
  const Reply reply = client.call("events.subscribe", {{"topics", {"log"}}, {"after", 1003}});
  EXPECT_TRUE(reply.result->at("complete").as_bool());
  EXPECT_EQ(reply.result->at("next").as_int64(), 1010);
  for (const unsigned seq : {1005U, 1007U, 1009U}) EXPECT_EQ(client.event().seq, seq);
  EXPECT_FALSE(client.call("events.subscribe", {{"topics", {"fault"}}, {"after", 3}})
                   .result->at("complete")
                   .as_bool());
}

TEST_F(ControlServerTest, ReplaysEventsOfTheDaemonBeforeThisOneAndThenContinues) {
  archive_.gaps = {{1, 899, "older than is kept"}};
  for (std::uint64_t seq = 901; seq <= 907; ++seq)
    archive_.kept.push_back({seq, "t", seq == 904 ? Topic::Log : Topic::Fault, R"({"text":"x"})"});
  for (int i = 0; i < 5'000; ++i) events_.publish(Topic::Fault, json::object{{"i", i}});
  Client client{serve()};
  client.hello();
  const Reply reply = client.call("events.subscribe", {{"topics", {"fault"}}, {"after", 901}});
  EXPECT_TRUE(reply.result->at("complete").as_bool());
  EXPECT_TRUE(reply.result->at("missing").as_array().empty());
  for (const unsigned seq : {902U, 903U, 905U, 906U, 907U}) EXPECT_EQ(client.event().seq, seq);
  for (unsigned seq = 1000; seq < 6'000; ++seq) ASSERT_EQ(client.event().seq, seq);
  events_.publish(Topic::Fault, json::object{});
  EXPECT_EQ(client.event().seq, 6'000U);

  const Reply incomplete = client.call("events.subscribe", {{"topics", {"log"}}, {"after", 800}});
  EXPECT_FALSE(incomplete.result->at("complete").as_bool());
  EXPECT_EQ(incomplete.result->at("missing").at(0).at("last"), 899);
  EXPECT_EQ(client.event().seq, 904U);
}

TEST_F(ControlServerTest, SaysThatWhatWasMissedCannotBeRead) {
  archive_.broken = true;
  Client client{serve()};
  client.hello();
  client.call("events.subscribe", {{"after", 900}});
  EXPECT_THAT(client.reply().result.error().message, HasSubstr("what was missed cannot be read: cell.db"));
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlServerTest, DisconnectsASlowReaderWhileOthersGetEveryEvent) {
  const auto port = serve();
  Client slow{port, 4096};
  Client quick{port};
  slow.hello();
  quick.hello();
  slow.call("events.subscribe");
  quick.call("events.subscribe");
  constexpr unsigned kRounds = 110, kOfRound = 50;
  for (unsigned round = 0; round < kRounds; ++round) {
    // The first are more than the kernel keeps for who reads nothing.
    const json::object data{{"text", std::string(round < 4 ? 60'000 : 10, 'x')}};
    for (unsigned i = 0; i < kOfRound; ++i) events_.publish(Topic::Fault, data);
    for (unsigned i = 0; i < kOfRound; ++i) ASSERT_EQ(quick.event().seq, 1000 + kOfRound * round + i);
  }
  EXPECT_EQ(too_slow_.get_future().wait_for(30s), std::future_status::ready);
}

TEST_F(ControlServerTest, ClosesEveryConnectionWhenItStops) {
  const auto port = serve();
  Client waiting{port};
  Client busy{port};
  waiting.hello();
  busy.hello();
  busy.send(control::encode_request(1, "campaign.start", {}));
  cell_.started.get_future().wait();
  on_loop([this] { server_.reset(); });
  EXPECT_TRUE(waiting.closed());
  EXPECT_TRUE(busy.closed());
}

TEST_F(ControlServerTest, ServesItsSchemaWhichKnowsItsMethods) {
  Client client{serve()};
  client.hello();
  EXPECT_EQ(client.call("rpc.discover").result->at("openrpc").as_string(), "1.2.6");
  std::vector<std::string> served = server_->methods();
  EXPECT_EQ(std::erase(served, "rpc.discover"), 1U);
  EXPECT_THAT(rpc::method_names(), testing::IsSupersetOf(served));
  const Reply one = client.call("rpc.discover", {{"method", "session.ping"}});
  EXPECT_EQ(one.result->at("name").as_string(), "session.ping");
  EXPECT_FALSE(one.result->at("examples").as_array().empty());
  EXPECT_EQ(client.code("rpc.discover", {{"method", "no.such"}}), -32004);
}

TEST_F(ControlServerTest, ListensOnLoopbackOnly) {
  EXPECT_THAT(try_start({"0.0.0.0", 0}).text, HasSubstr("needs TLS"));
  EXPECT_THAT(try_start({"192.0.2.1", 0}).text, HasSubstr("needs TLS"));
  EXPECT_THAT(try_start({"cell.example", 0}).text, HasSubstr("not an IP address"));
}

TEST_F(ControlServerTest, SaysWhoHoldsItsPort) {
  asio::io_context context;
  const tcp::acceptor holder{context, {asio::ip::address_v4::loopback(), 0}};
  const drivers::StartFailure failure = try_start({"127.0.0.1", holder.local_endpoint().port()});
  EXPECT_TRUE(failure.may_pass);
  EXPECT_THAT(failure.text,
              HasSubstr("is in use by daemon_control_ (process " + std::to_string(::getpid()) + ")"));
}

}  // namespace
}  // namespace truepose::daemon
