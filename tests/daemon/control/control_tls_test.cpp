#include <gmock/gmock.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>

#include "daemon/control/tls_identity.hpp"
#include "tests/certificates.hpp"
#include "tests/daemon/control_fixture.hpp"
#include "tests/no_more_files.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using control::Role;
using control::Topic;
using testing::HasSubstr;
namespace ssl = asio::ssl;

/// A client over TLS that blocks, by whatever OpenSSL does.
class TlsClient : public ProtocolClient {
 public:
  /// @param tune  of its own context, before it connects
  TlsClient(std::uint16_t port, const std::function<void(ssl::context&)>& tune = {}) {
    ssl::context settings{ssl::context::tls_client};
    if (tune) tune(settings);
    stream_.emplace(context_, settings);
    const timeval limit{.tv_sec = 30, .tv_usec = 0};
    stream_->next_layer().connect({asio::ip::address_v4::loopback(), port});
    ::setsockopt(stream_->next_layer().native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  }
  boost::system::error_code shake_hands() {
    boost::system::error_code error;
    stream_->handshake(ssl::stream_base::client, error);
    return error;
  }
  void send(std::string_view bytes) override { asio::write(*stream_, asio::buffer(bytes)); }
  std::string any_line() override {
    boost::system::error_code end;
    const std::size_t size = asio::read_until(*stream_, asio::dynamic_buffer(buffer_), '\n', end);
    if (end) return {};
    std::string line = buffer_.substr(0, size - 1);
    buffer_.erase(0, size);
    return line;
  }
  Reply hello(const json::object& more = {}) {
    json::object params{{"protocol", 1}};
    params.insert(more.begin(), more.end());
    return call("session.hello", params);
  }
  tcp::socket& socket() { return stream_->next_layer(); }
  /// The name in the daemon's certificate.
  std::string name_shown() {
    std::array<char, 64> name{};
    X509_NAME_get_text_by_NID(X509_get_subject_name(SSL_get0_peer_certificate(stream_->native_handle())),
                              NID_commonName, name.data(), static_cast<int>(name.size()));
    return name.data();
  }

 private:
  asio::io_context context_;
  std::optional<ssl::stream<tcp::socket>> stream_;
  std::string buffer_;
};

std::string why(const Reply& reply) { return reply.result ? "" : reply.result.error().message; }

class ControlTls : public ControlServerTest {
 protected:
  ControlTls() {
    certificates_.make("daemon");
    certificates_.make("panel");
    tls_ = {{"127.0.0.1", 0}, certificates_.certificate("daemon"), certificates_.key("daemon")};
    wall_ = std::chrono::system_clock::now();
  }
  std::uint16_t serve_tls(const ControlLimits& limits = {}) {
    serve(limits);
    return *server_->tls_port();
  }
  std::function<void(ssl::context&)> as(const std::string& name) const {
    return [this, name](ssl::context& settings) {
      settings.use_certificate_file(certificates_.certificate(name), ssl::context::pem);
      settings.use_private_key_file(certificates_.key(name), ssl::context::pem);
    };
  }
  void let_in_panel(Role role) {
    write_access({{{.name = "Panel 1",
                    .role = role,
                    .salt = {},
                    .hash = {},
                    .certificate = certificates_.fingerprint("panel")}}});
  }
  std::string warnings() {
    std::string said;
    on_loop([&] { said = warnings_; });
    return said;
  }
  /// The name in the certificate that the daemon shows from now on.
  std::string name_shown(std::uint16_t port) {
    TlsClient client{port};
    EXPECT_FALSE(client.shake_hands());
    return client.name_shown();
  }
  /// Lets the server look at its files.
  void let_it_look() {
    std::size_t asleep = 0;  // between two looks: this far ahead nothing else is due
    await("it has looked", [&] {
      on_loop([&] { asleep = clock_.sleepers_within(ControlLimits{}.look); });
      return asleep > 0;
    });
    advance(2s);
    on_loop([] {});
  }

  Certificates certificates_{folder_.path()};
};

TEST_F(ControlTls, LetsInByTheTokenAndSendsEvents) {
  TlsClient client{serve_tls()};
  ASSERT_FALSE(client.shake_hands());
  EXPECT_EQ(client.hello({{"token", std::string{kToken}}}).result->at("role").as_string(), "admin");
  EXPECT_TRUE(client.call("events.subscribe").result);
  events_.publish(Topic::Log, {{"text", "x"}});
  EXPECT_EQ(client.event().seq, 1000U);
  EXPECT_EQ(client.call("system.info").result->at("tls").at("fingerprint").as_string(),
            certificates_.fingerprint("daemon"));
}

TEST_F(ControlTls, ContinuesBehindTheLastEventThatAClientHasSeen) {
  TlsClient client{serve_tls()};
  ASSERT_FALSE(client.shake_hands());
  client.hello({{"token", std::string{kToken}}});
  for (int i = 0; i < 3; ++i) events_.publish(Topic::Log, {{"text", "x"}});
  EXPECT_EQ(client.call("events.subscribe", {{"after", 1000}}).result->at("complete"), true);
  EXPECT_EQ(client.event().seq, 1001U);
  EXPECT_EQ(client.event().seq, 1002U);
}

TEST_F(ControlTls, WantsATokenOfWhoShowsNoCertificate) {
  TlsClient client{serve_tls()};
  ASSERT_FALSE(client.shake_hands());
  EXPECT_THAT(why(client.hello()), HasSubstr("token"));
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlTls, KnowsAPanelByItsCertificate) {
  let_in_panel(Role::Viewer);
  TlsClient client{serve_tls(), as("panel")};
  ASSERT_FALSE(client.shake_hands());
  const Reply hello = client.hello();
  ASSERT_TRUE(hello.result) << why(hello);
  EXPECT_EQ(hello.result->at("name").as_string(), "Panel 1");
  EXPECT_EQ(hello.result->at("role").as_string(), "viewer");
  EXPECT_THAT(why(client.call("campaign.start")), HasSubstr("needs the role operator"));
}

TEST_F(ControlTls, RefusesACertificateThatNobodyIsKnownBy) {
  TlsClient client{serve_tls(), as("panel")};
  ASSERT_FALSE(client.shake_hands());
  const Reply hello = client.hello();
  EXPECT_EQ(Client::code_of(hello), -32001);
  EXPECT_THAT(why(hello), HasSubstr(certificates_.fingerprint("panel")));
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlTls, RefusesACertificateThatHasExpiredOrDoesNotHoldYet) {
  let_in_panel(Role::Admin);
  const auto port = serve_tls();
  const auto answer_at = [&](std::chrono::system_clock::time_point time) {
    on_loop([&] { wall_ = time; });
    TlsClient client{port, as("panel")};
    EXPECT_FALSE(client.shake_hands());
    const Reply hello = client.hello();
    EXPECT_EQ(Client::code_of(hello), -32001);
    return why(hello);
  };
  const auto now = std::chrono::system_clock::now();
  EXPECT_THAT(answer_at(now + std::chrono::days{101}), HasSubstr("'panel' expired on 20"));
  EXPECT_THAT(answer_at(now - std::chrono::days{1}), HasSubstr("is not valid before 20"));
}

TEST_F(ControlTls, EndsTheSessionOfACertificateThatIsRevoked) {
  let_in_panel(Role::Admin);
  TlsClient client{serve_tls(), as("panel")};
  ASSERT_FALSE(client.shake_hands());
  ASSERT_TRUE(client.hello().result);
  write_access({});
  let_it_look();
  EXPECT_THAT(why(client.reply()), HasSubstr("the access of Panel 1 was changed or revoked"));
  EXPECT_TRUE(client.closed());
}

TEST_F(ControlTls, RefusesTls12AndClearText) {
  const auto port = serve_tls();
  TlsClient old{port, [](ssl::context& settings) {
                  SSL_CTX_set_max_proto_version(settings.native_handle(), TLS1_2_VERSION);
                }};
  EXPECT_THAT(old.shake_hands().message(), HasSubstr("protocol version"));
  Client clear{port};
  clear.send_hello(kToken);
  while (!clear.closed()) {
  }
  EXPECT_THAT(warnings(), HasSubstr("no TLS with loopback"));
}

TEST_F(ControlTls, ClosesAHandshakeThatDoesNotEnd) {
  TlsClient client{serve_tls()};
  on_loop([] {});
  advance(4s);
  std::array<char, 1> none;
  boost::system::error_code error;
  client.socket().read_some(asio::buffer(none), error);
  EXPECT_EQ(error, asio::error::eof);
}

TEST_F(ControlTls, TakesANewCertificateWithoutARestartAndKeepsOpenSessions) {
  const auto port = serve_tls();
  TlsClient before{port};
  ASSERT_FALSE(before.shake_hands());
  ASSERT_TRUE(before.hello({{"token", std::string{kToken}}}).result);
  EXPECT_EQ(name_shown(port), "daemon");
  certificates_.make("next");
  fs::rename(certificates_.certificate("next"), certificates_.certificate("daemon"));
  let_it_look();
  EXPECT_EQ(name_shown(port), "daemon");
  EXPECT_THAT(warnings(), HasSubstr("is not the private key of"));
  fs::rename(certificates_.key("next"), certificates_.key("daemon"));
  let_it_look();
  EXPECT_EQ(name_shown(port), "next");
  EXPECT_TRUE(before.call("cell.status").result);
}

TEST_F(ControlTls, TakesANewCertificateAsSoonAsItCanBeRead) {
  auto identity = TlsIdentity::load({.certificate = certificates_.certificate("daemon"),
                                     .key = certificates_.key("daemon")})
                      .value();
  certificates_.make("next");
  fs::rename(certificates_.certificate("next"), certificates_.certificate("daemon"));
  fs::rename(certificates_.key("next"), certificates_.key("daemon"));
  {
    const NoMoreFiles none;
    EXPECT_THAT(identity.refresh().error(), HasSubstr("Too many open files"));
    EXPECT_FALSE(identity.refresh().value()) << "reported twice";
  }
  EXPECT_EQ(identity.certificate().name, "daemon");
  EXPECT_TRUE(identity.refresh().value());
  EXPECT_EQ(identity.certificate().name, "next");
}

TEST_F(ControlTls, WarnsOfTheEndOfItsCertificateAMonthAheadOnceADay) {
  wall_ += std::chrono::days{71};
  serve_tls();
  const std::string once = warnings();
  EXPECT_THAT(once, HasSubstr("the daemon's certificate ends on 20"));
  let_it_look();
  EXPECT_EQ(warnings(), once);
  advance(23h);
  let_it_look();
  EXPECT_EQ(warnings(), once);
  advance(1h);
  await("it warns again", [&] {
    let_it_look();
    return warnings() == once + once;
  });
}

TEST_F(ControlTls, SaysOfACertificateWhoseEndHasPassedThatItExpired) {
  wall_ += std::chrono::days{200};
  serve_tls();
  EXPECT_THAT(warnings(), HasSubstr("the daemon's certificate expired on 20"));
}

TEST_F(ControlTls, StartsOnlyWithACertificateAndItsPrivateKey) {
  const config::Endpoint endpoint{"127.0.0.1", 0};
  fs::permissions(certificates_.key("daemon"), fs::perms::others_read, fs::perm_options::add);
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("chmod 600"));
  tls_->key = certificates_.key("panel");
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("is not the private key of"));
  tls_->certificate = token_file();
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("holds no certificate in PEM form"));
  tls_->certificate = folder_.path() / "none.pem";
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("truepose tls init"));
}

TEST_F(ControlTls, ListensOnAnyAddress) {
  tls_->listen = {"0.0.0.0", 0};
  EXPECT_EQ(try_start({"127.0.0.1", 0}).text, "");
  on_loop([this] { server_.reset(); });
  tls_->listen = {"cell.example", 0};
  EXPECT_THAT(try_start({"127.0.0.1", 0}).text, HasSubstr("not an IP address"));
}

}  // namespace
}  // namespace truepose::daemon
