#include <gmock/gmock.h>
#include <unistd.h>

#include "daemon/control/private_file.hpp"
#include "tests/daemon/control_fixture.hpp"

namespace truepose::daemon {
namespace {

using namespace test;
using testing::HasSubstr;

class ControlTokenFile : public ControlServerTest {};

TEST_F(ControlTokenFile, IsReadByRootWhereRootGaveItToTheServicesGroup) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root may give a file to another group";
  constexpr gid_t kGroup = 65534;
  fs::permissions(token_file(), fs::perms{0640});
  ASSERT_EQ(::chown(token_file().c_str(), 0, kGroup), 0);
  EXPECT_TRUE(read_private_file(token_file(), 1024)) << "as the package installs it";
  ASSERT_EQ(::chown(token_file().c_str(), kGroup, kGroup), 0);
  EXPECT_FALSE(read_private_file(token_file(), 1024)) << "of another owner";
  ASSERT_EQ(::chown(token_file().c_str(), 0, kGroup), 0);
  fs::permissions(token_file(), fs::perms{0660});
  EXPECT_FALSE(read_private_file(token_file(), 1024)) << "the group may write";
}

TEST_F(ControlTokenFile, MustBePrivate) {
  const config::Endpoint endpoint{"127.0.0.1", 0};
  fs::permissions(token_file(), fs::perms::others_read, fs::perm_options::add);
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("chmod 600"));
  fs::permissions(token_file(), fs::perms{0660});
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("others may read or write it"));
  write_token("short");
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("16..1024 characters"));
  write_token("0123456789abcdef 0123456789abcdef");
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("without blanks inside"));
  fs::remove(token_file());
  EXPECT_THAT(try_start(endpoint).text, HasSubstr("does not exist"));
}

TEST_F(ControlTokenFile, MayBeReadByTheDaemonsOwnGroup) {
  fs::permissions(token_file(), fs::perms{0640});
  EXPECT_EQ(try_start({"127.0.0.1", 0}).text, "");
}

TEST_F(ControlTokenFile, OfAnotherOwnerIsRefusedWithTheCommandThatGivesItToTheGroup) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
  ASSERT_EQ(::chown(token_file().c_str(), 65534, 65534), 0);
  fs::permissions(token_file(), fs::perms{0640});
  EXPECT_THAT(try_start({"127.0.0.1", 0}).text, HasSubstr("run: chgrp root "));
  ASSERT_EQ(::chown(token_file().c_str(), 65534, ::getegid()), 0);
  EXPECT_EQ(try_start({"127.0.0.1", 0}).text, "");
}

}  // namespace
}  // namespace truepose::daemon
