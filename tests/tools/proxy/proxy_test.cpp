#include "tools/proxy/proxy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <deque>
#include <functional>
#include <memory>

#include "proto/record/json_io.hpp"
#include "tests/no_more_files.hpp"

namespace truepose::proxy {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using asio::ip::tcp;
using asio::ip::udp;
using boost::system::error_code;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

const asio::ip::address kHere = asio::ip::address_v4::loopback();
constexpr std::uint64_t kSeed = 11;

std::string address(std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); }

std::uint16_t port_of(const std::string& listens) { return config::parse_endpoint(listens)->port; }

/// Keeps what comes, and from whom.
class Datagrams {
 public:
  explicit Datagrams(asio::io_context& io) : socket_{io, {kHere, 0}} { receive(); }
  ~Datagrams() { socket_.close(); }

  std::uint16_t port() const { return socket_.local_endpoint().port(); }
  void send(const std::string& bytes, std::uint16_t to) { socket_.send_to(asio::buffer(bytes), {kHere, to}); }

  std::deque<std::string> received;
  std::deque<std::uint16_t> senders;

 private:
  void receive() {
    socket_.async_receive_from(asio::buffer(buffer_), sender_, [this](error_code error, std::size_t size) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        received.emplace_back(buffer_.data(), size);
        senders.push_back(sender_.port());
      }
      receive();
    });
  }

  udp::socket socket_;
  udp::endpoint sender_;
  std::array<char, 4096> buffer_{};
};

/// One end of a connection: keeps the pieces that it read, and how it ended.
class Stream {
 public:
  explicit Stream(tcp::socket socket) : socket_{std::move(socket)} { read(); }
  ~Stream() { socket_.close(); }

  void send(const std::string& bytes) { asio::write(socket_, asio::buffer(bytes)); }
  void finish() { socket_.shutdown(tcp::socket::shutdown_send); }
  std::string text() const {
    std::string text;
    for (const std::string& piece : pieces) text += piece;
    return text;
  }

  std::deque<std::string> pieces;
  error_code end;

 private:
  void read() {
    socket_.async_read_some(asio::buffer(buffer_), [this](error_code error, std::size_t size) {
      if (error == asio::error::operation_aborted) return;
      if (size > 0) pieces.emplace_back(buffer_.data(), size);
      end = error;
      if (!error) read();
    });
  }

  tcp::socket socket_;
  std::array<char, 4096> buffer_{};
};

class AProxy : public testing::Test {
 protected:
  std::uint16_t add(Protocol protocol, std::uint16_t target) {
    return port_of(proxy.add({protocol, {"127.0.0.1", 0}, {"127.0.0.1", target}}).value());
  }
  Reply obey(const std::string& line) { return proxy.obey(parse_command(line).value()); }
  void until(const std::function<bool()>& done) {
    while (!done()) io.run_one();
  }
  double counted(const char* pointer) {
    return json::value(record::to_json(proxy.statistics())).at_pointer(pointer).to_number<double>();
  }

  /// Connects through a new route. @return the client's end and the target's
  std::pair<std::unique_ptr<Stream>, std::unique_ptr<Stream>> connection() {
    tcp::acceptor target{io, {kHere, 0}};
    tcp_port = add(Protocol::Tcp, target.local_endpoint().port());
    tcp::socket client{io}, accepted{io};
    bool done = false;
    target.async_accept(accepted, [&](error_code) { done = true; });
    client.connect({kHere, tcp_port});
    until([&] { return done; });
    return {std::make_unique<Stream>(std::move(client)), std::make_unique<Stream>(std::move(accepted))};
  }

  asio::io_context io;
  Proxy proxy{io.get_executor(), kSeed};
  std::uint16_t tcp_port = 0;
};

TEST_F(AProxy, GivesEachClientAPortOfItsOwnThatStays) {
  Datagrams target{io}, one{io}, other{io};
  const std::uint16_t port = add(Protocol::Udp, target.port());
  for (Datagrams* from : {&one, &other, &one}) {
    const std::size_t before = target.received.size();
    from->send("frame", port);
    until([&] { return target.received.size() > before; });
  }
  EXPECT_EQ(target.senders[0], target.senders[2]);
  EXPECT_NE(target.senders[0], target.senders[1]);
  target.send("reply", target.senders[1]);
  until([&] { return !other.received.empty(); });
  EXPECT_THAT(other.received, ElementsAre("reply"));
  EXPECT_THAT(other.senders, ElementsAre(port));
  EXPECT_THAT(one.received, SizeIs(0));
}

TEST(AProxyOfAGivenSeed, LosesTheSameAgainAndCountsIt) {
  const auto experiment = [](std::uint64_t seed) {
    asio::io_context own;
    Proxy proxy{own.get_executor(), seed};
    Datagrams target{own}, client{own};
    const std::uint16_t port =
        port_of(proxy.add({Protocol::Udp, {"127.0.0.1", 0}, {"127.0.0.1", target.port()}}).value());
    proxy.obey(parse_command(R"({"loss": 0.3, "direction": "to_target"})").value());
    const auto counted = [&](const char* pointer) {
      return json::value(record::to_json(proxy.statistics())).at_pointer(pointer).to_number<int>();
    };
    for (int i = 0; i < 200; ++i) {
      client.send(std::to_string(i), port);
      while (counted("/routes/0/to_target/received") == i) own.run_one();
    }
    while (static_cast<int>(target.received.size()) < counted("/routes/0/to_target/forwarded")) own.run_one();
    EXPECT_EQ(counted("/routes/0/to_target/lost") + static_cast<int>(target.received.size()), 200);
    return target.received;
  };
  const auto once = experiment(kSeed);
  EXPECT_GT(once.size(), 100);
  EXPECT_LT(once.size(), 180);
  EXPECT_EQ(once, experiment(kSeed));
  EXPECT_NE(once, experiment(kSeed + 1));
}

TEST_F(AProxy, DelaysADatagramBehindAnother) {
  Datagrams target{io}, client{io};
  const std::uint16_t port = add(Protocol::Udp, target.port());
  obey(R"({"delay_ms": 20})");
  client.send("first", port);
  until([&] { return counted("/routes/0/to_target/received") == 1; });
  obey(R"({"delay_ms": 0})");
  client.send("second", port);
  until([&] { return target.received.size() == 2; });
  EXPECT_THAT(target.received, ElementsAre("second", "first"));
}

TEST_F(AProxy, ForwardsAConnectionBothWaysAndItsEnds) {
  const auto [client, target] = connection();
  client->send("command");
  until([&] { return target->text() == "command"; });
  target->send("answer");
  until([&] { return client->text() == "answer"; });
  client->finish();
  until([&] { return target->end.failed(); });
  EXPECT_EQ(target->end, asio::error::eof);
  target->send("last words");
  until([&] { return client->text() == "answerlast words"; });
}

TEST_F(AProxy, ResetsBothEndsOfACutConnection) {
  const auto [client, target] = connection();
  client->send("x");
  until([&] { return target->text() == "x"; });
  obey(R"({"cut": true})");
  until([&] { return client->end.failed() && target->end.failed(); });
  EXPECT_EQ(client->end, asio::error::connection_reset);
  EXPECT_EQ(target->end, asio::error::connection_reset);
  EXPECT_EQ(counted("/routes/0/cut"), 1);
  EXPECT_EQ(counted("/routes/0/open"), 0);
}

TEST_F(AProxy, HoldsAHalfOpenConnectionUntilItIsLifted) {
  const auto [client, target] = connection();
  obey(R"({"half_open": true, "direction": "to_target"})");
  client->send("kept");
  target->send("passes");
  until([&] { return client->text() == "passes"; });
  EXPECT_EQ(target->text(), "");
  EXPECT_FALSE(client->end.failed());
  obey(R"({"half_open": false})");
  until([&] { return target->text() == "kept"; });
}

TEST_F(AProxy, JoinsWhatComesCloseTogether) {
  const auto [client, target] = connection();
  obey(R"({"coalesce_ms": 50})");
  client->send("one ");
  client->send("two");
  until([&] { return target->text() == "one two"; });
  EXPECT_THAT(target->pieces, ElementsAre("one two"));
}

TEST_F(AProxy, DeliversASlowStreamInSmallPieces) {
  const auto [client, target] = connection();
  obey(R"({"bytes_per_s": 200})");
  client->send("0123456789012345678901234");
  until([&] { return target->text().size() == 25; });
  EXPECT_EQ(target->text(), "0123456789012345678901234");
  EXPECT_EQ(target->pieces.front().size(), 10);
}

TEST_F(AProxy, ResetsAClientWhoseTargetRefuses) {
  std::uint16_t nobody = 0;
  {
    const tcp::acceptor gone{io, {kHere, 0}};
    nobody = gone.local_endpoint().port();
  }
  const std::uint16_t port = add(Protocol::Tcp, nobody);
  tcp::socket socket{io};
  socket.connect({kHere, port});
  Stream client{std::move(socket)};
  until([&] { return client.end.failed(); });
  EXPECT_EQ(client.end, asio::error::connection_reset);
}

TEST_F(AProxy, SetsTheFaultsOfOneRouteAlone) {
  Datagrams target{io}, client{io};
  const std::uint16_t one = add(Protocol::Udp, target.port()), other = add(Protocol::Udp, target.port());
  obey(R"({"nul_bytes": 1, "route": ")" + address(one) + "\"}");
  client.send("a", one);
  until([&] { return target.received.size() == 1; });
  client.send("b", other);
  until([&] { return target.received.size() == 2; });
  EXPECT_THAT(target.received, ElementsAre(std::string("a\0", 2), "b"));
  EXPECT_THAT(obey(R"({"loss": 1, "route": "127.0.0.1:1"})").error,
              HasSubstr("no route listens on 127.0.0.1:1"));
}

TEST_F(AProxy, FollowsItsTimelineInTheOrderOfTime) {
  Datagrams target{io}, client{io};
  const std::uint16_t port = add(Protocol::Udp, target.port());
  proxy.follow(parse_timeline("# the second line is the first in time\n"
                              "{\"at_ms\": 20, \"nul_bytes\": 2}\n"
                              "\n"
                              "{\"at_ms\": 1, \"clear\": true, \"nul_bytes\": 1, \"duplicate\": 1}\n")
                   .value());
  std::size_t sent = 0;
  while (target.received.empty() || target.received.back() != std::string("x\0\0", 3)) {
    client.send("x", port);
    ++sent;
    until([&] { return counted("/routes/0/to_target/received") == static_cast<double>(sent); });
    io.poll();
  }
  EXPECT_GT(counted("/routes/0/to_target/duplicated"), 0) << "the fault that began before";
}

TEST_F(AProxy, WaitsWhereNoFileIsLeftForAClientAndServesItOnceThereIs) {
  const auto first = connection();
  tcp::socket client{io};
  EXPECT_LT(steps_without_files(io, client, tcp_port), 10U) << "it asked again and again";
  until([&] { return counted("/routes/0/connections") == 2; });
}

TEST_F(AProxy, SaysWhichAddressItCannotHave) {
  const auto refused = proxy.add({Protocol::Udp, {"192.0.2.1", 5}, {"127.0.0.1", 5}});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), HasSubstr("192.0.2.1:5"));
}

TEST(AProxyCommand, IsRefusedByTheNameOfItsKey) {
  const auto why_not = [](const char* line) { return parse_command(line).error(); };
  EXPECT_THAT(why_not(R"({"loss": 2})"), HasSubstr("loss"));
  EXPECT_THAT(why_not(R"({"lost": 1})"), HasSubstr("lost"));
  EXPECT_EQ(why_not(R"({"garble": 0.1})"), "params.garble: unknown parameter, renamed to 'corrupt'");
  EXPECT_EQ(why_not(R"({"join_ms": 5})"), "params.join_ms: unknown parameter, renamed to 'coalesce_ms'");
  EXPECT_THAT(why_not(R"({"direction": "up"})"), HasSubstr("to_target"));
  EXPECT_THAT(why_not("[]"), HasSubstr("object"));
  EXPECT_THAT(why_not("{"), HasSubstr("byte"));
  EXPECT_THAT(parse_timeline("{\"at_ms\": 1}\n{\"loss\": 1}\n").error(), HasSubstr("2: at_ms"));
}

TEST(AProxyRoute, IsReadFromItsTwoAddresses) {
  const RouteOptions route = parse_route(Protocol::Udp, "0.0.0.0:49152=192.168.44.1:49153").value();
  EXPECT_EQ(route.listen.port, 49152);
  EXPECT_EQ(route.target.host, "192.168.44.1");
  EXPECT_THAT(parse_route(Protocol::Tcp, "127.0.0.1:7000").error(), HasSubstr("LISTEN=TARGET"));
  EXPECT_FALSE(parse_route(Protocol::Tcp, "127.0.0.1:7000=host"));
}

}  // namespace
}  // namespace truepose::proxy
