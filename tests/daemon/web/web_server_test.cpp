// HTTP, and the control protocol over WebSocket: the same sessions as over TCP.
#include "daemon/web/web_server.hpp"

#include <gmock/gmock.h>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>

#include "daemon/web/web_pages.hpp"
#include "tests/certificates.hpp"
#include "tests/daemon/web_client.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::Topic;
using testing::HasSubstr;
using testing::StartsWith;
namespace ssl = asio::ssl;

class WebServerTest : public ControlServerTest {
 protected:
  ~WebServerTest() override {
    on_loop([this] { web_.reset(); });
  }
  std::uint16_t serve_web(const WebLimits& limits = {}, const ControlLimits& control_limits = {}) {
    serve(control_limits);
    std::string failure;
    on_loop([&] {
      auto started = WebServer::start(io_.get_executor(),
                                      {clock_, *server_, [this] { return health_; }, [] { return "up 1\n"; },
                                       [this](const std::string& text) { warnings_ += text; }},
                                      web_config_, limits);
      if (started) web_ = *std::move(started);
      if (web_) web_->serve();
      if (!started) failure = started.error().text;
    });
    EXPECT_EQ(failure, "");
    return web_->port();
  }

  config::WebConfig web_config_{.listen = config::Endpoint{"127.0.0.1", 0}};
  Health health_{.status = "ok", .threads = {{"RSI", {"running", 4ms}}, {"store", {"idle", 0ms}}}};
  std::unique_ptr<WebServer> web_;
};

TEST_F(WebServerTest, ServesDashboardMetricsAndHealthWithoutATokenOnLoopback) {
  HttpClient client{serve_web()};
  const HttpAnswer page = client.get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.header, HasSubstr("Content-Type: text/html"));
  EXPECT_EQ(page.body, dashboard_page());
  const HttpAnswer metrics = client.get("/metrics");
  EXPECT_THAT(metrics.header, HasSubstr("text/plain; version=0.0.4"));
  EXPECT_EQ(metrics.body, "up 1\n");
  EXPECT_EQ(client.get("/healthz").body,
            R"({"status":"ok","threads":{"RSI":{"state":"running","still_ms":4},)"
            R"("store":{"state":"idle","still_ms":0}}})"
            "\n");
  on_loop([this] { health_ = {.status = "stuck", .threads = {}}; });
  const HttpAnswer unwell = client.get("/healthz");
  EXPECT_EQ(unwell.status, 503);
  EXPECT_EQ(unwell.body, "{\"status\":\"stuck\",\"threads\":{}}\n");
}

TEST_F(WebServerTest, AnswersWhatItDoesNotServe) {
  HttpClient client{serve_web()};
  EXPECT_EQ(client.get("/etc/passwd").status, 404);
  EXPECT_EQ(client.get("/rpc").status, 426);
  client.ask("DELETE", "/");
  EXPECT_THAT(client.answer().header, HasSubstr("405"));
  client.ask("HEAD", "/");
  const HttpAnswer head = client.answer(false);
  EXPECT_EQ(head.status, 200);
  EXPECT_THAT(head.header, HasSubstr("Content-Length: " + std::to_string(dashboard_page().size())));
  client.send("HEAD / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(client.answer(false).status, 403);
  EXPECT_EQ(client.get("/healthz").status, 200) << "what follows no body is the next answer";
  client.ask("POST", "/", "Content-Length: 5\r\n");
  EXPECT_EQ(client.answer().status, 413);
  EXPECT_TRUE(client.closed());
  HttpClient rude{web_->port()};
  rude.send("\x16\x03\x01 this is no HTTP\r\n\r\n");
  EXPECT_EQ(rude.answer().status, 400);
  EXPECT_TRUE(rude.closed());
  HttpClient verbose{web_->port()};
  verbose.ask("GET", "/", "X: " + std::string(9000, 'x') + "\r\n");
  EXPECT_EQ(verbose.answer().status, 431);
}

TEST_F(WebServerTest, IsNoServerOfAnotherNameThatResolvesToThisMachine) {
  HttpClient client{serve_web()};
  for (const std::string host : {"evil.example:7280", "127.0.0.1.evil.example", ""}) {
    client.send("GET /metrics HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    EXPECT_EQ(client.answer().status, 403) << host;
  }
  for (const std::string host : {"localhost:7280", "LOCALHOST", "[::1]:7280", "127.0.0.1:9"}) {
    client.send("GET /metrics HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    EXPECT_EQ(client.answer().status, 200) << host;
  }
}

TEST_F(WebServerTest, SpeaksTheControlProtocolOverWebSocket) {
  WebSocketClient client{serve_web()};
  EXPECT_EQ(client.handshake().status, 101);
  EXPECT_THAT(client.handshake().header, HasSubstr("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
  EXPECT_EQ(client.greeting().at("params").at("cell").as_string(), "cell 1");
  EXPECT_EQ(ProtocolClient::code_of(client.hello()), 0);
  EXPECT_EQ(client.call("cell.status").result->at("method").as_string(), "cell.status");
  client.call("events.subscribe");
  events_.publish(Topic::Fault, json::object{{"code", "E_BEAM"}});
  EXPECT_EQ(client.event().topic, "fault");
  client.send_frame(WebSocketClient::kPing, "there?");
  EXPECT_EQ(client.code("session.ping"), 0);
  EXPECT_EQ(client.pong(), "there?");
}

TEST_F(WebServerTest, ContinuesBehindTheLastEventThatAClientHasSeen) {
  WebSocketClient client{serve_web()};
  client.hello();
  for (int i = 0; i < 3; ++i) events_.publish(Topic::Fault, json::object{{"code", "E_BEAM"}});
  const Reply reply = client.call("events.subscribe", {{"after", 1000}});
  EXPECT_EQ(reply.result->at("complete"), true);
  EXPECT_EQ(client.event().seq, 1001U);
  EXPECT_EQ(client.event().seq, 1002U);
}

TEST_F(WebServerTest, TakesOneMessageForOneRequestHoweverItIsLaidOutAndCut) {
  WebSocketClient client{serve_web()};
  client.hello();
  client.send_frame(WebSocketClient::kText,
                    "{\n  \"jsonrpc\": \"2.0\",\r\n  \"id\": 7,\n  \"method\": \"cell.status\"\n}");
  EXPECT_EQ(client.reply().id, control::Id{7});
  client.send_bytes(WebSocketClient::frame(0x01, R"({"jsonrpc": "2.0", "id": 8, )"));
  client.send_bytes(WebSocketClient::frame(0x00, R"("method": )"));
  client.send_bytes(WebSocketClient::frame(0x80, R"("cell.status"})"));
  EXPECT_EQ(client.reply().id, control::Id{8});
  client.send_frame(WebSocketClient::kText, "");
  EXPECT_EQ(client.code("cell.status"), 0) << "an empty message is nothing";
  client.send_frame(WebSocketClient::kBinary, R"({"jsonrpc": "2.0", "id": 9, "method": "cell.status"})");
  EXPECT_TRUE(client.closed());
  EXPECT_EQ(client.farewell(),
            "\x03\xEB"
            "messages are text here, not binary")
      << "1003";
}

TEST_F(WebServerTest, TakesWhatComesTogetherWithARequestForTheNextOne) {
  HttpClient client{serve_web()};
  const std::string request = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
  client.send(request + "HEAD / HTTP/1.0\r\nHost: localhost\r\nConnection: keep-alive\r\n\r\n" + request +
              "GET /rpc HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
              "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n" +
              WebSocketClient::frame(0x81, control::encode_request(7, "session.challenge", {})));
  EXPECT_EQ(client.answer().status, 200);
  EXPECT_EQ(client.answer(false).status, 200);
  EXPECT_THAT(client.answer().body, StartsWith("{\"status\":\"ok\""));
  const HttpAnswer upgraded = client.answer();
  EXPECT_EQ(upgraded.status, 101) << upgraded.header;
  std::string come;
  while (come.find("\"id\":7") == std::string::npos && come.size() < 4096) {
    const std::string byte = client.read(1);
    if (byte.empty()) break;
    come += byte;
  }
  EXPECT_THAT(come, HasSubstr("\"id\":7")) << come;
}

TEST_F(WebServerTest, AnswersPingsWhileACallRunsAndOthersWait) {
  WebSocketClient client{serve_web()};
  client.hello();
  client.send(control::encode_request(71, "campaign.start", {}));
  cell_.started.get_future().wait();
  client.send(control::encode_request(72, "cell.status", {}));
  client.send(control::encode_request(73, "cell.status", {}));
  client.send_frame(WebSocketClient::kPing, "there?");
  const std::string pong = client.next_pong();
  on_loop([this] { cell_.release(); });
  EXPECT_EQ(pong, "there?");
  for (const std::int64_t id : {71, 72, 73}) EXPECT_EQ(client.reply().id, control::Id{id});
}

TEST_F(WebServerTest, LetsInByTheSameTokensRolesAndLimits) {
  write_access({{control::entry_for_token("Panel", control::Role::Viewer, "token of a panel, long")}});
  const auto port = serve_web({}, {.sessions = 2});
  WebSocketClient stranger{port}, panel{port};
  EXPECT_EQ(stranger.code("cell.status"), -32001);
  EXPECT_TRUE(stranger.closed());
  EXPECT_EQ(panel.hello("token of a panel, long").result->at("role").as_string(), "viewer");
  EXPECT_EQ(panel.code("campaign.start"), -32002);
  Client over_tcp{server_->port()};
  EXPECT_EQ(ProtocolClient::code_of(over_tcp.hello()), 0);
  EXPECT_EQ(over_tcp.code("control.acquire"), 0);
  WebSocketClient third{port};
  EXPECT_EQ(ProtocolClient::code_of(third.hello()), -32006) << "two sessions are open, whatever carries them";
  EXPECT_EQ(over_tcp.call("audit.list").result->at("records").as_array().size(), 2U);
}

TEST_F(WebServerTest, LetsPagesOfOthersInOnlyWhereTheyAreListed) {
  web_config_.origins = {"https://hmi.plant"};
  const auto port = serve_web();
  EXPECT_EQ(WebSocketClient(port, "Origin: http://127.0.0.1:7280\r\n").handshake().status, 101);
  EXPECT_EQ(WebSocketClient(port, "Origin: https://hmi.plant\r\n").handshake().status, 101);
  for (const char* origin : {"https://evil.example", "null", "http://127.0.0.1:80", "http://hmi.plant"})
    EXPECT_EQ(WebSocketClient(port, std::string{"Origin: "} + origin + "\r\n").handshake().status, 403)
        << origin;
}

TEST_F(WebServerTest, SaysWhyItClosesASession) {
  const auto port = serve_web();
  WebSocketClient silent{port}, idle{port};
  idle.hello();
  EXPECT_TRUE(silent.greeting().is_object());
  advance(3s);
  EXPECT_THAT(silent.reply().result.error().message, HasSubstr("session.hello"));
  EXPECT_TRUE(silent.closed());
  pass_until_open(0);
  EXPECT_THAT(idle.reply().result.error().message, HasSubstr("session.ping"));
  EXPECT_TRUE(idle.closed());
  WebSocketClient long_winded{port};
  long_winded.hello();
  long_winded.send_frame(WebSocketClient::kText, std::string(200'000, 'x'));
  EXPECT_THAT(long_winded.reply().result.error().message, HasSubstr("65536 bytes"));
  EXPECT_TRUE(long_winded.closed());
}

TEST_F(WebServerTest, ClosesASessionWhoseMessageDoesNotEnd) {
  WebSocketClient dawdler{serve_web()};
  dawdler.hello();
  dawdler.send_bytes(WebSocketClient::frame(0x01, "{"));
  WebSocketClient witness{web_->port()};
  witness.hello();
  pass_until_open(1);
  EXPECT_THAT(dawdler.reply().result.error().message, HasSubstr("did not end"));
}

TEST_F(WebServerTest, ServesOthersWhateverNumberOfConnectionsStandAndSayNothing) {
  const auto port = serve_web({.connections = 8});
  std::vector<std::unique_ptr<HttpClient>> crowd;
  for (int i = 0; i < 200; ++i) {
    crowd.push_back(std::make_unique<HttpClient>(port));
    crowd.back()->send(i % 2 ? "GET / HT" : "");
    if (i % 50 == 0) {
      EXPECT_EQ(HttpClient{port}.get("/healthz").status, 200) << i;
    }
  }
  EXPECT_EQ(HttpClient{port}.get("/healthz").status, 200);
  std::size_t standing = 0;
  on_loop([&] { standing = web_->connections(); });
  EXPECT_LE(standing, 8U);
  advance(5s);
  for (const auto& one : crowd) EXPECT_TRUE(one->closed());
}

TEST_F(WebServerTest, LetsTheRightTokenInHoweverManyWebSocketsStand) {
  const auto port = serve_web({}, {.guests_of_peer = 3});
  std::vector<std::unique_ptr<WebSocketClient>> crowd;
  for (int i = 0; i < 200; ++i) crowd.push_back(std::make_unique<WebSocketClient>(port));
  WebSocketClient right{port};
  EXPECT_EQ(ProtocolClient::code_of(right.hello()), 0);
  EXPECT_EQ(right.code("cell.status"), 0);
}

TEST_F(WebServerTest, ClosesAClientThatReadsNothing) {
  const auto port = serve_web();
  WebSocketClient deaf{port, "", 4096};
  deaf.hello();
  deaf.call("events.subscribe");
  const json::object data{{"text", std::string(60'000, 'x')}};
  for (int i = 0; i < 200; ++i) events_.publish(Topic::Log, data);
  std::size_t open = 1;
  while (open > 0) {
    advance(5s);
    on_loop([&] { open = server_->load().connections; });
  }
  EXPECT_EQ(HttpClient{port}.get("/healthz").status, 200);
}

TEST_F(WebServerTest, ClosesEveryConnectionWhenItStops) {
  const auto port = serve_web();
  HttpClient waiting{port};
  EXPECT_EQ(waiting.get("/healthz").status, 200);
  on_loop([this] { web_.reset(); });
  EXPECT_TRUE(waiting.closed());
}

/// Over TLS, where others may come from.
class WebTls : public WebServerTest {
 protected:
  WebTls() {
    certificates_.make("daemon");
    certificates_.make("panel");
    tls_ = {{"127.0.0.1", 0}, certificates_.certificate("daemon"), certificates_.key("daemon")};
    wall_ = std::chrono::system_clock::now();
    web_config_.listen = config::Endpoint{"0.0.0.0", 0};
  }
  /// What comes back for a request up to a text in it.
  std::string ask(const std::string& request, const std::string& until, const std::string& as = "") {
    ssl::context settings{ssl::context::tls_client};
    if (!as.empty()) {
      settings.use_certificate_file(certificates_.certificate(as), ssl::context::pem);
      settings.use_private_key_file(certificates_.key(as), ssl::context::pem);
    }
    asio::io_context context;
    ssl::stream<tcp::socket> stream{context, settings};
    stream.next_layer().connect({asio::ip::address_v4::loopback(), web_->port()});
    const timeval limit{.tv_sec = 30, .tv_usec = 0};
    ::setsockopt(stream.next_layer().native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    stream.handshake(ssl::stream_base::client);
    asio::write(stream, asio::buffer(request));
    std::string answer;
    boost::system::error_code end;
    asio::read_until(stream, asio::dynamic_buffer(answer), until, end);
    return answer;
  }
  std::string get(const std::string& target, const std::string& more = "", const std::string& as = "") {
    return ask("GET " + target + " HTTP/1.1\r\nHost: cell3.plant:7280\r\n" + more + "\r\n", "\r\n\r\n", as);
  }

  Certificates certificates_{folder_.path()};
};

TEST_F(WebTls, ShowsMetricsAndHealthToWhoeverIsKnown) {
  write_access({{{.name = "Panel 1",
                  .role = control::Role::Viewer,
                  .salt = {},
                  .hash = {},
                  .certificate = certificates_.fingerprint("panel")}}});
  serve_web();
  EXPECT_THAT(get("/"), HasSubstr(" 200 "));
  EXPECT_THAT(get("/metrics"), HasSubstr(" 401 "));
  EXPECT_THAT(get("/healthz", "Authorization: Bearer wrong\r\n"), HasSubstr(" 401 "));
  EXPECT_THAT(get("/metrics", "Authorization: Bearer " + std::string{kToken} + "\r\n"), HasSubstr(" 200 "));
  EXPECT_THAT(get("/healthz", "", "panel"), HasSubstr(" 200 "));
  EXPECT_THAT(get("/healthz", "", "daemon"), HasSubstr(" 401 ")) << "a certificate that nobody let in";
}

TEST_F(WebTls, SpeaksTheControlProtocolToo) {
  serve_web();
  const std::string upgrade =
      "GET /rpc HTTP/1.1\r\nHost: cell3.plant:7280\r\nOrigin: https://cell3.plant:7280\r\nUpgrade: websocket\r\n"
      "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
  EXPECT_THAT(ask(upgrade, "cell 1"), testing::AllOf(HasSubstr(" 101 "), HasSubstr("greeting")));
}

TEST_F(WebTls, ClosesHandshakesThatDoNotEnd) {
  const auto port = serve_web();
  std::vector<std::unique_ptr<HttpClient>> crowd;
  for (int i = 0; i < 20; ++i) {
    crowd.push_back(std::make_unique<HttpClient>(port));
    if (i % 2) crowd.back()->send("\x16\x03\x01\x02");
  }
  EXPECT_THAT(get("/"), HasSubstr(" 200 "));
  advance(5s);
  for (const auto& one : crowd) EXPECT_TRUE(one->closed());
}

TEST(WebAddress, IsThisMachinesOwnUnlessThereIsTls) {
  EXPECT_FALSE(web_address({"127.0.0.1", 7280}, true)->tls);
  EXPECT_FALSE(web_address({"localhost", 7280}, false)->tls);
  EXPECT_TRUE(web_address({"10.0.0.5", 7280}, true)->tls);
  EXPECT_THAT(web_address({"0.0.0.0", 7280}, false).error(), HasSubstr("needs TLS"));
  EXPECT_THAT(web_address({"cell.plant", 7280}, true).error(), HasSubstr("not an IP address"));
}

}  // namespace
}  // namespace truepose::daemon
