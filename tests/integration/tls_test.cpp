// The command line and the daemon over TLS, with what `truepose tls` makes, judged by openssl.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/await.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class OverTls : public testing::Test {
 protected:
  OverTls()
      : cell_{{.cell = {{"  #tls:", "  tls:"},
                        {"  #  listen: 0.0.0.0:7211", "    listen: 127.0.0.1:0"},
                        {"  #  certificate:", "    certificate:"},
                        {"  #  key:", "    key:"}}}} {
    made({"tls", "init", "--dir", tls(), "--host", "127.0.0.1", "--host", "cell.plant"});
    made({"tls", "client", "Panel 1", "--dir", tls()});
  }
  fs::path tls(const std::string& file = "") const { return cell_.folder() / "tls" / file; }
  static void made(const std::vector<std::string>& words) {
    const Finished finished = run_program("truepose", words);
    ASSERT_EQ(finished.exit_code, 0) << finished.err;
  }
  void start() {
    cell_.start_daemon();
    daemon_ = "127.0.0.1:" + std::to_string(cell_.tls_port());
  }
  Finished truepose(std::vector<std::string> words, const std::vector<std::string>& by) const {
    words.insert(words.end(), {"--daemon", daemon_});
    words.insert(words.end(), by.begin(), by.end());
    return run_program("truepose", words);
  }
  std::vector<std::string> by_certificate() const {
    return {"--tls-ca", tls("ca.pem"), "--cert", tls("Panel-1.pem"), "--key", tls("Panel-1.key")};
  }

  LiveCell cell_;
  std::string daemon_;
};

TEST_F(OverTls, OpensslTakesWhatTheCommandLineMakes) {
  const auto verify = [&](const std::string& purpose, const std::string& file) {
    return run_program("/usr/bin/openssl",
                       {"verify", "-x509_strict", "-CAfile", tls("ca.pem"), "-purpose", purpose, tls(file)});
  };
  EXPECT_EQ(verify("sslserver", "daemon.pem").exit_code, 0) << verify("sslserver", "daemon.pem").err;
  EXPECT_EQ(verify("sslclient", "Panel-1.pem").exit_code, 0);
  EXPECT_NE(verify("sslserver", "Panel-1.pem").exit_code, 0);
  for (const char* key : {"ca.key", "daemon.key", "Panel-1.key"})
    EXPECT_EQ(fs::status(tls(key)).permissions(), fs::perms::owner_read | fs::perms::owner_write) << key;
}

TEST_F(OverTls, APanelIsKnownByItsCertificateUntilItIsRevoked) {
  start();
  EXPECT_THAT(truepose({"status"}, by_certificate()).err,
              HasSubstr("truepose access add NAME --certificate"));
  made({"access", "add", "Panel 1", "--role", "viewer", "--certificate", tls("Panel-1.pem"), "--cell",
        cell_.cell_file()});
  const Finished status = truepose({"status"}, by_certificate());
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_THAT(truepose({"stream", "stop"}, by_certificate()).err, HasSubstr("needs the role operator"));
  made({"access", "revoke", "Panel 1", "--cell", cell_.cell_file()});
  EXPECT_EQ(truepose({"status"}, by_certificate()).exit_code, 2);
}

TEST_F(OverTls, ATokenGoesOnlyToTheDaemonThatTheCaVouchesFor) {
  start();
  const std::vector<std::string> by_token{"--token-file", cell_.token_file()};
  std::vector<std::string> right{"--tls-ca", tls("ca.pem")}, wrong{"--tls-ca", tls("other/ca.pem")};
  right.insert(right.end(), by_token.begin(), by_token.end());
  wrong.insert(wrong.end(), by_token.begin(), by_token.end());
  EXPECT_EQ(truepose({"status"}, right).exit_code, 0);

  made({"tls", "init", "--dir", tls("other"), "--host", "127.0.0.1"});
  const Finished refused = truepose({"status"}, wrong);
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("its certificate does not hold: "));

  made({"tls", "init", "--dir", tls(), "--host", "10.0.0.9"});
  std::string said;
  await(
      "the new certificate is refused for its address",
      [&] {
        said = truepose({"status"}, right).err;
        return said.find("IP address mismatch") != said.npos;
      },
      [&] { return said; });
}

TEST_F(OverTls, ADaemonInTheClearIsNoDaemonOverTls) {
  start();
  const Finished refused =
      run_program("truepose", {"status", "--daemon", "127.0.0.1:" + std::to_string(cell_.control_port()),
                               "--token-file", cell_.token_file(), "--tls-ca", tls("ca.pem")});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("no TLS with the daemon at 127.0.0.1"));
}

}  // namespace
}  // namespace truepose
