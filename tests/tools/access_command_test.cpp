#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>

#include "daemon/control/audit_trail.hpp"
#include "tests/certificates.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class AccessCommand : public testing::Test {
 protected:
  AccessCommand() {
    std::string text = text_of(kShipped + "/cell.yaml");
    for (const char* folder : {"robots/kr210", "kuka/rsi"}) {
      for (auto at = text.find(folder); at != text.npos; at = text.find(folder, at + kShipped.size() + 2))
        text.insert(at, kShipped + "/");
    }
    fs::create_directory(folder_.path() / "state");
    const auto store = text.find("\nstore:"), end = text.find('\n', store + 1);
    text.replace(store, end - store, "\nstore: state/cell.sqlite");
    folder_.write("cell.yaml", text);
  }
  Finished access(std::vector<std::string> words) {
    words.insert(words.begin(), "access");
    words.insert(words.end(), {"--cell", folder_.path() / "cell.yaml"});
    return run_program("truepose", words);
  }
  fs::path file() const { return folder_.path() / "state/cell.sqlite.access"; }

  const std::string kShipped = std::string{TRUEPOSE_SOURCE_DIR} + "/config";
  TempFolder folder_;
};

TEST_F(AccessCommand, TakesTheCellFileOfTheFolderItIsCalledInByItsBareName) {
  std::string text = text_of(folder_.path() / "cell.yaml");
  text.replace(text.find("state/cell.sqlite"), 17, "cell.sqlite");
  folder_.write("cell.yaml", text);
  const StandsIn here{folder_.path()};
  const auto bare = [](std::vector<std::string> words) {
    words.insert(words.begin(), "access");
    words.insert(words.end(), {"--cell", "cell.yaml"});
    return run_program("truepose", words);
  };
  const Finished added = bare({"add", "panel 1", "--role", "operator"});
  EXPECT_EQ(added.exit_code, 0) << added.err;
  EXPECT_EQ(bare({"list"}).out, "panel 1  operator\n");
  EXPECT_EQ(bare({"revoke", "panel 1"}).exit_code, 0);
}

TEST_F(AccessCommand, KeepsNoTokenAndLetsNobodyElseReadWhatItKeeps) {
  const std::string token = access({"add", "Anna", "--role", "viewer"}).out;
  EXPECT_THAT(text_of(file()), Not(HasSubstr(token.substr(0, token.size() - 1))));
  EXPECT_EQ(fs::status(file()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AccessCommand, WritesAsTheOwnerOfTheFolder) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  ASSERT_EQ(::chown((folder_.path() / "state").c_str(), 65534, 65534), 0);
  fs::permissions(folder_.path(), fs::perms::others_exec, fs::perm_options::add);
  ASSERT_EQ(access({"add", "Anna", "--role", "viewer"}).exit_code, 0);
  struct stat found {};
  ASSERT_EQ(::stat(file().c_str(), &found), 0);
  EXPECT_EQ(found.st_uid, 65534U);
  EXPECT_EQ(found.st_gid, 65534U);
}

TEST_F(AccessCommand, LosesNoneOfSeveralAddedAtOnce) {
  {
    std::vector<std::jthread> adders;
    for (int i = 0; i < 8; ++i)
      adders.emplace_back([this, i] { access({"add", "panel " + std::to_string(i), "--role", "viewer"}); });
  }
  const std::string listed = access({"list"}).out;
  EXPECT_EQ(std::ranges::count(listed, '\n'), 8) << listed;
}

TEST_F(AccessCommand, SaysWhatIsWrong) {
  access({"add", "Anna", "--role", "viewer"});
  const Finished twice = access({"add", "Anna", "--role", "admin"});
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.err, HasSubstr("Anna is in "));
  const Finished unknown = access({"revoke", "Bert"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("no Bert in "));
  const Finished role = access({"add", "Bert", "--role", "boss"});
  EXPECT_EQ(role.exit_code, 2);
  EXPECT_THAT(role.err, HasSubstr("engineer"));
  EXPECT_EQ(access({"add", "line\nbreak", "--role", "viewer"}).exit_code, 2);
  fs::permissions(file(), fs::perms::others_read, fs::perm_options::add);
  const Finished open = access({"list"});
  EXPECT_EQ(open.exit_code, 2);
  EXPECT_THAT(open.err, HasSubstr("chmod 600"));
}

TEST_F(AccessCommand, LetsNobodyInByACertificateThatHasExpired) {
  const Certificates certificates{folder_.path()};
  certificates.make("panel");
  certificates.end_in("panel", -1);
  const std::vector<std::string> add{"add",    "panel",         "--role",
                                     "viewer", "--certificate", certificates.certificate("panel")};
  const Finished expired = access(add);
  EXPECT_EQ(expired.exit_code, 1);
  EXPECT_THAT(expired.err, HasSubstr("panel.pem: the certificate expired on "));
  constexpr int kToTheYear9300 = 2'660'000;
  certificates.end_in("panel", kToTheYear9300);
  EXPECT_EQ(access(add).exit_code, 0);
}

TEST_F(AccessCommand, IsOfACellWhoseAuditTrailIsVerified) {
  const auto verify = [this](std::vector<std::string> more) {
    more.insert(more.begin(), {"audit", "verify", "--cell", folder_.path() / "cell.yaml"});
    return run_program("truepose", more);
  };
  const fs::path trail = folder_.path() / "state/cell.sqlite.audit";
  const Finished none = verify({});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr(trail.string() + ": there is none"));
  folder_.write("state/cell.sqlite.audit", "");
  EXPECT_EQ(verify({}).out, trail.string() + ": 0 records, none changed and none missing\n");
  EXPECT_EQ(verify({"--json"}).out, "{\"file\":\"" + trail.string() + "\",\"records\":0,\"head\":\"" +
                                        std::string(64, '0') + "\",\"acknowledged\":[]}\n");
  folder_.write("state/cell.sqlite.audit", "{}\n");
  const Finished changed = verify({"--json"});
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_EQ(changed.out, "");
  fs::remove(trail);
  {
    const auto of_cell =
        daemon::AuditTrail::open(trail, "2026-11-28T10:00:00.000Z", std::array{control::AuditHead{7}});
    ASSERT_TRUE(of_cell) << of_cell.error();
  }
  const Finished put_aside = verify({});
  EXPECT_EQ(put_aside.exit_code, 1);
  EXPECT_THAT(put_aside.err, AllOf(HasSubstr("before record 8: it is missing, and had 7 records at least"),
                                   HasSubstr("this is not acknowledged")));
  {
    auto of_cell = daemon::AuditTrail::open(trail, "2026-11-28T10:00:00.000Z");
    const boost::json::object asked{
        {"who", "uid 0"}, {"method", "audit.acknowledge"}, {"params", {{"name", "Anna Beer"}}}};
    ASSERT_EQ(of_cell->append(asked), 9U);
    ASSERT_TRUE(of_cell->append({{"of", 9}, {"result", "ok"}}));
  }
  const Finished acknowledged = verify({});
  EXPECT_EQ(acknowledged.exit_code, 0);
  EXPECT_THAT(acknowledged.out,
              AllOf(HasSubstr("acknowledged by Anna Beer (uid 0)"), HasSubstr(": 10 records,")));
  const fs::path log =
      folder_.write("log", "[info] audit trail: 12 records, head " + std::string(64, 'a') + "\n");
  EXPECT_THAT(verify({"--journal", log}).err, HasSubstr("it has 10 records, and had 12"));
  fs::remove(trail);
  EXPECT_THAT(changed.err, HasSubstr("record 1 was changed"));
}

}  // namespace
}  // namespace truepose
