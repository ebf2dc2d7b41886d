#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace fs = std::filesystem;
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

TEST_F(AccessCommand, AddsListsAndRevokes) {
  EXPECT_EQ(access({"list"}).out, "");
  const Finished added = access({"add", "panel 1", "--role", "operator"});
  EXPECT_EQ(added.exit_code, 0) << added.err;
  EXPECT_THAT(added.out, testing::MatchesRegex("access-[0-9a-f]{32}\n"));
  EXPECT_EQ(access({"add", "Anna", "--role", "engineer"}).exit_code, 0);
  EXPECT_EQ(access({"list"}).out, "panel 1  operator\nAnna     engineer\n");
  EXPECT_EQ(access({"revoke", "panel 1"}).exit_code, 0);
  EXPECT_EQ(access({"list"}).out, "Anna  engineer\n");
}

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
                                        std::string(64, '0') + "\"}\n");
  folder_.write("state/cell.sqlite.audit", "{}\n");
  const Finished changed = verify({"--json"});
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_EQ(changed.out, "");
  EXPECT_THAT(changed.err, HasSubstr("line 1 was changed"));
}

}  // namespace
}  // namespace truepose
